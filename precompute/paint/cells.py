# SPDX-License-Identifier: GPL-3.0-or-later
"""Recipes of cells that each have a direction of their own: dot matrix, glitter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .recipe import Maps, Plane, Recipe, Setting

#: Part of a turn between the directions of neighbouring dots: the golden section never repeats itself.
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def luminance(picture: np.ndarray) -> np.ndarray:
    """Luminance of linear Rec.709 values (ITU-R BT.709)."""
    return picture @ np.array([0.2126, 0.7152, 0.0722])


def _dots(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """A square grid of round dots; a picture's brightness gives each its direction, else the golden section does."""
    count = values["cells"]
    x, y = (0.5 * (axis + 1.0) * count for axis in (plane.x, plane.y))
    column, row = (np.clip(np.floor(axis), 0, count - 1).astype(int) for axis in (x, y))
    if pictures:
        grey = np.clip(luminance(pictures[0]), 0.0, 1.0)
        index = row * count + column
        total = np.bincount(index.ravel(), minlength=count**2)
        mean = np.bincount(index.ravel(), grey.ravel(), count**2) / np.maximum(total, 1)
        turn = np.sqrt(mean)[index]  # the eye's brightness, so that greys spread over the half turn
    else:
        turn = np.mod((column + count * row) * _GOLDEN, 1.0)
    inside = np.hypot(x - column - 0.5, y - row - 0.5) <= 0.5 * values["fill"]
    return {"rotation": np.pi * turn, "mask": inside.astype(np.float32)}


def _glitter(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """Cells about random points (one in each square of a grid, so that none is far from its neighbours)."""
    count = values["cells"]
    random = np.random.default_rng(values["seed"])
    side = count + 4  # two squares beyond each edge, whose points own pixels inside
    points = random.uniform(0.0, 1.0, (2, side, side)).astype(np.float32)
    turn = random.uniform(0.0, np.pi, (side, side)).astype(np.float32)
    low = float(values["least_scale"])
    scale = random.uniform(low, max(1.0, low), (side, side)).astype(np.float32)
    x, y = (np.float32(0.5 * count) * (axis.astype(np.float32) + 1) for axis in (plane.x, plane.y))
    column, row = (np.clip(np.floor(axis), 0, count - 1).astype(np.int32) for axis in (x, y))
    nearest = np.full(plane.shape, np.inf, np.float32)
    owner = np.zeros(plane.shape, np.int32)
    for down in (-1, 0, 1):
        for across in (-1, 0, 1):
            r, c = row + (2 + down), column + (2 + across)
            away = (points[0][r, c] + (c - 2) - x) ** 2 + (points[1][r, c] + (r - 2) - y) ** 2
            closer = away < nearest
            np.copyto(nearest, away, where=closer)
            np.copyto(owner, r * side + c, where=closer)
    return {"rotation": turn.ravel()[owner], "scale": scale.ravel()[owner]}


RECIPES = (
    Recipe(
        "dots", "Dot Matrix", "Dots of which each has its own direction; a picture's brightness chooses them.", _dots,
        (
            Setting("cells", 64, 1, 1024, "Dots along the longer side"),
            Setting("fill", 0.9, 0.05, 1.5, "Diameter of a dot, part of its cell; from 1.42 on nothing stays bare"),
        ),
    ),
    Recipe(
        "glitter", "Glitter", "Cells of random direction and period.", _glitter,
        (
            Setting("cells", 96, 1, 1024, "Cells along the longer side"),
            Setting("least_scale", 0.7, 0.05, 1.0, "Smallest period, part of the table's"),
            Setting("seed", 1, 0, 2**31 - 1, "Another number gives other cells"),
        ),
    ),
)  # fmt: skip
