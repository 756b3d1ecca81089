# SPDX-License-Identifier: GPL-3.0-or-later
"""What a recipe of paint is: a name, its parameters, and a function from a plane to maps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Setting:
    """A number that shapes a recipe.

    Parameters
    ----------
    name
        As keyword and, with dashes, as option; it ends in its unit.
    default
        A whole number stays one.
    minimum, maximum
        Limits, both allowed.
    help
        One line for people.
    """

    name: str
    default: float | int
    minimum: float
    maximum: float
    help: str


@dataclass(frozen=True)
class Plane:
    """Where the maps are asked for.

    Parameters
    ----------
    x, y
        ``(rows, cols)`` coordinates from -1 to 1 along the longer side, y upwards, the middle at 0.
    size_m
        Length of the longer side in metres: what the surface measures in the scene.
    period_m
        The table's grating period at Scale 1, metres.
    """

    x: np.ndarray
    y: np.ndarray
    size_m: float
    period_m: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.x.shape  # type: ignore[return-value]


#: What a recipe returns: any of scale, depth, rotation, mask, and ``info`` for people.
Maps = dict[str, Any]


@dataclass(frozen=True)
class Recipe:
    """A recipe of paint.

    Parameters
    ----------
    name, label, description
        For the command line and the panel.
    build
        ``build(plane, values, pictures) -> Maps``; pictures are ``(rows, cols, 3)`` linear Rec.709, row 0 at the
        bottom, one value a pixel of the plane.
    settings
        Its parameters.
    pictures
        How many pictures it needs.
    """

    name: str
    label: str
    description: str
    build: Callable[[Plane, Mapping[str, Any], tuple[np.ndarray, ...]], Maps]
    settings: tuple[Setting, ...] = ()
    pictures: int = 0
