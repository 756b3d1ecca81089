# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the preset structures, made from the presets' own lists of parameters."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty

from ..precompute.presets import PRESETS, Parameter, Preset

ITEMS: list[tuple[str, str, str]] = [(preset.name, preset.label, preset.description) for preset in PRESETS.values()]


class ItemPictures:
    """Loads pictures when they are first asked for.

    Parameters
    ----------
    folder
        Of files ``IDENTIFIER.png``.
    items
        ``(identifier, label, description)``.
    """

    def __init__(self, folder: Path, items: list[tuple[str, str, str]]) -> None:
        self._folder, self._plain = folder, items
        self._previews: Any = None

    def items(self) -> list[tuple[str, str, str, int, int]]:
        """The items with pictures; registering asks for it."""
        from bpy.utils import previews

        if self._previews is None:
            self._previews = previews.new()
        found = []
        for number, (name, label, description) in enumerate(self._plain):
            path = self._folder / f"{name}.png"
            if path.is_file() and name not in self._previews:
                self._previews.load(name, str(path), "IMAGE")
            icon = self._previews[name].icon_id if name in self._previews else 0
            found.append((name, label, description, icon, number))
        return found

    def drop(self) -> None:
        """Free them."""
        from bpy.utils import previews

        if self._previews is not None:
            previews.remove(self._previews)
            self._previews = None


#: Small pictures by preset, for menus; made by tools/docs/preset_thumbnails.py.
pictures = ItemPictures(Path(__file__).resolve().parent / "preset_pictures", ITEMS)


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
