# SPDX-License-Identifier: GPL-3.0-or-later
"""From the panel's properties, in the units of people, to the core's parameters, and what changed since."""

from __future__ import annotations

import json
from typing import Any

from ...precompute.parameters import BakeParameters
from ...precompute.stack import material_of, parse_stack, split_films
from .. import paths
from ..given import is_given
from ..numbers import decimal
from . import light_file

#: Those of the panel Levelling.
LEVELLING = ("use_crop", "crop_um", "level", "align_rows", "clip_percent", "smooth_nm", "tile")

#: Properties that decide a bake, on the scene and on the operator, in the order of the panel.
FIELDS = (
    *LEVELLING, "ensemble", "replicas", "sigma_s_um", "detail", "error_percent", "illuminant", "illuminant_file",
    "illuminant_data", "series", "tolerance", "limit_mb", "substrate", "films", "lacquer", "energy",
    "scale_headroom", "depth_headroom",
)  # fmt: skip


#: Of them, what changes no table: of a light's file its values count.
_UNSEEN = ("limit_mb", "illuminant_file")


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
        replicas=tuple(owner.replicas),
        series=owner.series,
        tolerance=decimal(owner.tolerance),
        **levelling(owner),
        illuminant=light_file.illuminant(owner),
        detail=decimal(owner.detail),
        error=round(0.01 * decimal(owner.error_percent), 9),
        limit_bytes=owner.limit_mb * 1_000_000,
        **stuff(owner.substrate, owner.films, owner.lacquer),
        energy=owner.energy,
        scale_headroom=decimal(owner.scale_headroom),
        depth_headroom=decimal(owner.depth_headroom),
    )


def stuff(substrate: str, films: str, lacquer: str) -> dict[str, Any]:
    """The core's parameters of the surface's stuff, as the panel has it typed; files may be relative to the .blend.

    Raises
    ------
    ParameterError
        If there is no such material or film.
    """
    layer = _file(lacquer)
    return {
        "stack": parse_stack(_file(substrate), [_file(film) for film in split_films(films)]),
        "lacquer": material_of(layer) if layer else None,
    }


def _file(text: str) -> str:
    text = text.strip()
    return str(paths.absolute(text)) if text.startswith("//") else text


def levelling(owner: Any) -> dict[str, Any]:
    """The core's parameters of `LEVELLING` alone."""
    return {
        "crop_m": tuple(decimal(x) * 1e-6 for x in owner.crop_um) if owner.use_crop else None,
        "level": owner.level,
        "align_rows": owner.align_rows,
        "clip_percent": decimal(owner.clip_percent) or None,
        "smooth_m": decimal(owner.smooth_nm) * 1e-9,
        "tile": owner.tile,
    }


def copy(source: Any, target: Any, only_unset: bool = False) -> None:
    """Copy `FIELDS` from one owner to another, or only those that the target was not given."""
    for name in FIELDS:
        if not (only_unset and is_given(target, name)):
            value = _plain(getattr(source, name))
            if _plain(getattr(target, name)) != value:
                setattr(target, name, value)


def remember(owner: Any) -> dict[str, Any]:
    """The values of `FIELDS`, for a recipe."""
    values = {name: _plain(getattr(owner, name)) for name in FIELDS}
    return {**values, "illuminant_data": light_file.values(owner)}


def _plain(value: Any) -> Any:
    """A property's value as JSON holds it, numbers as the user typed them."""
    if isinstance(value, float):
        return decimal(value)
    return value if isinstance(value, (str, bool, int)) else [decimal(x) if isinstance(x, float) else x for x in value]


def recall(values: dict[str, Any], owner: Any) -> None:
    """Write remembered values back; names and choices of other releases are passed over."""
    for name in FIELDS:
        if name in values:
            try:
                setattr(owner, name, values[name])
            except TypeError:
                continue


def changed(recipe: str, state: Any) -> list[str]:
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
        if name in _UNSEEN or name not in values or values[name] == now[name]:
            continue
        if name == "illuminant_data" and ("Illuminant" in labels or light_file.same(values[name], now[name])):
            continue
        labels.append(state.bl_rna.properties[name].name)
    return labels
