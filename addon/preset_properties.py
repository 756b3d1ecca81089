# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the preset structures, made from the presets' own lists of parameters."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty

from ..precompute.presets import PRESETS, Parameter, Preset

ITEMS: list[tuple[str, str, str]] = [(preset.name, preset.label, preset.description) for preset in PRESETS.values()]

#: For people; lengths carry their unit in the label since Blender has no nanometres.
_UNITS = {"um": "um", "nm": "nm", "deg": "deg", "percent": "%"}


def label(parameter: Parameter) -> str:
    """Name with its unit: ``period_um`` becomes ``Period (um)``."""
    words = parameter.name.removesuffix(f"_{parameter.unit}") if parameter.unit else parameter.name
    title = bpy.path.display_name(words).title()
    return f"{title} ({_UNITS.get(parameter.unit, parameter.unit)})" if parameter.unit else title


def _property(parameter: Parameter) -> Any:
    given: dict[str, Any] = {"name": label(parameter), "description": parameter.help, "default": parameter.default}
    if isinstance(parameter.default, bool):
        return BoolProperty(**given)
    given |= {"min": parameter.minimum, "max": parameter.maximum}
    if isinstance(parameter.default, int):
        return IntProperty(**{**given, "min": int(given["min"]), "max": int(given["max"])})
    return FloatProperty(**given, precision=3)


def _group(preset: Preset) -> type[bpy.types.PropertyGroup]:
    annotations = {parameter.name: _property(parameter) for parameter in preset.parameters}
    return type(
        f"DIFFRACTION_PG_preset_{preset.name}",
        (bpy.types.PropertyGroup,),
        {"__annotations__": annotations, "__doc__": preset.description},
    )


#: A property group for each preset, by its name.
GROUPS: dict[str, type[bpy.types.PropertyGroup]] = {preset.name: _group(preset) for preset in PRESETS.values()}


def all_parameters() -> dict[str, Any]:
    """Every preset's parameters as properties of one operator; presets that share a name share meaning and unit."""
    return {p.name: _property(p) for preset in PRESETS.values() for p in preset.parameters}
