# SPDX-License-Identifier: GPL-3.0-or-later
"""From the panel's properties, in the units of people, to the core's parameters, and what changed since."""

from __future__ import annotations

import json
from typing import Any

import bpy

from ..precompute.parameters import BakeParameters
from .numbers import decimal

#: Properties that decide a bake, on the scene and on the operator, in the order of the panel.
FIELDS = (
    "level", "clip_percent", "ensemble", "sigma_s_um", "detail", "illuminant", "series", "tolerance", "limit_mb",
)  # fmt: skip

#: Those of the panel Levelling.
LEVELLING = ("level", "clip_percent")


def parameters(owner: Any) -> BakeParameters:
    """The core's parameters of whatever holds `FIELDS`: the scene's group or an operator.

    Raises
    ------
    ParameterError
        If a value is out of its range.
    """
    return BakeParameters(
        sigma_s_m=decimal(owner.sigma_s_um) * 1e-6 or None,
        ensemble=owner.ensemble,
        series=owner.series,
        tolerance=decimal(owner.tolerance),
        **levelling(owner),
        illuminant=owner.illuminant,
        detail=decimal(owner.detail),
        limit_bytes=owner.limit_mb * 1_000_000,
    )


def levelling(owner: Any) -> dict[str, Any]:
    """The core's parameters of `LEVELLING` alone."""
    return {"level": owner.level, "clip_percent": decimal(owner.clip_percent) or None}


def copy(source: Any, target: Any, only_unset: bool = False) -> None:
    """Copy `FIELDS` from one owner to another, or only those that the target was not given."""
    for name in FIELDS:
        if not (only_unset and target.properties.is_property_set(name)):
            value = getattr(source, name)
            if getattr(target, name) != value:
                setattr(target, name, value)


def remember(owner: Any) -> dict[str, Any]:
    """The values of `FIELDS`, for a recipe."""
    values = {name: getattr(owner, name) for name in FIELDS}
    return {name: decimal(value) if isinstance(value, float) else value for name, value in values.items()}


def recall(values: dict[str, Any], owner: Any) -> None:
    """Write remembered values back; names and choices of other releases are passed over."""
    for name in FIELDS:
        if name in values:
            try:
                setattr(owner, name, values[name])
            except TypeError:
                continue


def changed(recipe: str, state: bpy.types.PropertyGroup) -> list[str]:
    """Labels of what differs between a table's recipe and the panel; empty where all is as it was baked.

    Parameters
    ----------
    recipe
        JSON, see `recipe.make`; empty for a table that came from elsewhere, of which nothing is known.
    state
        The scene's group.
    """
    if not recipe:
        return []
    then = json.loads(recipe)
    labels = []
    if then.get("sha256") != state.source_sha256 or then.get("reading", "{}") != (state.reading or "{}"):
        labels.append("Scan")
    now, values = remember(state), then.get("settings", {})
    for name in FIELDS:
        if name != "limit_mb" and name in values and values[name] != now[name]:
            labels.append(state.bl_rna.properties[name].name)
    return labels
