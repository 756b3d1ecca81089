# SPDX-License-Identifier: GPL-3.0-or-later
"""All recipes by name, and how a paint is made of one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import ParameterError, SizeLimitError
from . import cells, grooves, picture, views
from .maps import Paint
from .recipe import Plane, Recipe, Setting

RECIPES: dict[str, Recipe] = {
    recipe.name: recipe for module in (grooves, cells, views, picture) for recipe in module.RECIPES
}

#: Most pixels a side.
LIMIT_PIXELS = 8192


def make_paint(
    name: str,
    period_m: float,
    pixels: int = 1024,
    size_m: float = 0.05,
    pictures: Sequence[np.ndarray] = (),
    **settings: Any,
) -> Paint:
    """Turn a recipe into maps.

    Parameters
    ----------
    name
        One of ``RECIPES``.
    period_m
        The table's grating period, metres: what Scale 1 means.
    pixels
        Along the longer side; pictures give the aspect, without one the maps are square.
    size_m
        What the longer side measures in the scene, metres; only `lens` minds.
    pictures
        ``(rows, cols, 3)`` linear Rec.709, row 0 at the *bottom*, as many as the recipe takes.
    **settings
        The recipe's settings in the units their names carry.

    Returns
    -------
    Paint
        Maps of the four sockets; ``info`` says what could not be shown.

    Raises
    ------
    ParameterError
        If the recipe or a setting is not known, a value is out of its limits, or pictures are missing.
    SizeLimitError
        If the maps would have more than 8192 pixels a side.
    """
    recipe = RECIPES.get(name)
    if recipe is None:
        raise ParameterError(f"There is no recipe '{name}'; choose one of {', '.join(RECIPES)}.")
    for what, value in (("period", period_m), ("size", size_m)):
        if not (math.isfinite(value) and value > 0):
            raise ParameterError(f"A {what} of {value:g} m makes no sense; give a positive number.")
    known = {setting.name: setting for setting in recipe.settings}
    unknown = [key for key in settings if key not in known]
    if unknown:
        raise ParameterError(f"The recipe '{name}' has no setting {unknown[0]}; it has {', '.join(known) or 'none'}.")
    values = {key: _value(setting, settings.get(key)) for key, setting in known.items()}
    given = _pictures(recipe, pictures)
    plane = _plane(pixels, given[0].shape[:2] if given else (1, 1), size_m, period_m)
    maps = recipe.build(plane, values, tuple(_resampled(picture, plane.shape) for picture in given))
    info = {
        "recipe": name, "settings": values, "period_m": float(period_m), "size_m": float(size_m),
        **maps.pop("info", {}),
    }  # fmt: skip
    ones = np.ones(plane.shape, np.float32)
    return Paint(
        maps.get("scale", ones), maps.get("depth", ones), maps.get("rotation", 0.0 * ones), maps.get("mask", ones), info
    )


def _value(setting: Setting, given: Any) -> float | int:
    if given is None:
        return setting.default
    try:
        value = float(given)
    except (TypeError, ValueError):
        value = math.nan
    whole = isinstance(setting.default, int)
    if not setting.minimum <= value <= setting.maximum or (whole and value != int(value)):
        kind = "a whole number" if whole else "a number"
        raise ParameterError(f"{setting.name} is {given}; give {kind} from {setting.minimum:g} to {setting.maximum:g}.")
    return int(value) if whole else value


def _pictures(recipe: Recipe, pictures: Sequence[np.ndarray]) -> list[np.ndarray]:
    most = max(recipe.pictures, 1 if recipe.name == "dots" else 0)
    if not recipe.pictures <= len(pictures) <= most:
        wanted = {0: "no picture", 1: "one picture", 2: "two pictures"}[recipe.pictures]
        raise ParameterError(f"The recipe '{recipe.name}' takes {wanted}; {len(pictures)} given.")
    found = [np.asarray(each, float) for each in pictures]
    for each in found:
        if each.ndim != 3 or each.shape[2] != 3 or min(each.shape[:2]) < 1 or not np.isfinite(each).all():
            raise ParameterError("A picture for a paint is rows, columns and three colours, all finite.")
    return found


def _plane(pixels: int, aspect: tuple[int, int], size_m: float, period_m: float) -> Plane:
    longer = int(pixels)
    if longer < 1:
        raise ParameterError(f"{pixels} pixels are no picture; give at least 1.")
    if longer > LIMIT_PIXELS:
        raise SizeLimitError(f"{pixels} pixels a side are above the limit of {LIMIT_PIXELS}; give fewer.")
    rows, cols = (max(1, round(longer * side / max(aspect))) for side in aspect)
    x, y = ((np.arange(n) + 0.5 - 0.5 * n) * (2.0 / longer) for n in (cols, rows))
    across, up = np.meshgrid(x, y)
    return Plane(across, up, float(size_m), float(period_m))


def _resampled(picture: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """A picture on the plane's pixels: means where it is finer, the nearest pixel where it is coarser."""
    for axis, count in enumerate(shape):
        have = picture.shape[axis]
        if have == count:
            continue
        edges = np.arange(count + 1) * (have / count)
        if have < count:
            picture = np.take(picture, np.minimum((edges[:-1] + 0.5 * have / count).astype(int), have - 1), axis)
            continue
        sums = np.concatenate([np.zeros_like(np.take(picture, [0], axis)), np.cumsum(picture, axis)], axis)
        whole = np.minimum(edges.astype(int), have - 1)
        part = (edges - whole).reshape([-1 if a == axis else 1 for a in range(3)])
        at = np.take(sums, whole, axis) + part * np.take(picture, whole, axis)
        picture = np.diff(at, axis=axis) * (count / have)
    return picture
