# SPDX-License-Identifier: GPL-3.0-or-later
"""A light as it enters the scene's list: numbers, or what a driver makes them from."""

from __future__ import annotations

import math
import re
from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

import bpy

#: Functions of Blender's simple expressions that are used here.
_FUNCTIONS = {"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt, "max": max}


@dataclass(frozen=True)
class Variable:
    """One number of a data-block."""

    name: str
    owner: bpy.types.ID
    path: str


@dataclass(frozen=True)
class Drive:
    """A number that follows others: their sum, or an expression simple enough to run with scripts switched off."""

    variables: tuple[Variable, ...]
    expression: str = ""

    def value(self) -> float:
        """What it amounts to now: a driver made in the middle of a render has no say before the next."""
        numbers = {each.name: float(_resolve(each)) for each in self.variables}
        if not self.expression:
            return sum(numbers.values())
        return float(eval(self.expression, {"__builtins__": {}, **_FUNCTIONS}, numbers))  # texts of this package alone


def _resolve(variable: Variable) -> float:
    """A number of a data-block; of a matrix `path_resolve` knows no single element."""
    owner: Any = variable.owner
    matrix = re.fullmatch(r"matrix_world\[(\d)\]\[(\d)\]", variable.path)
    if matrix is not None:
        column, row = map(int, matrix.groups())
        return owner.matrix_world[row][column]
    return owner.path_resolve(variable.path)


#: What one number of the list is: itself, or what drives it.
Entry = float | Drive


@dataclass(frozen=True)
class Source:
    """A light of a scene.

    Parameters
    ----------
    key
        Identity together with all that decides the entries but their values: as long as it stays, nothing need be
        written anew.
    name
        For people.
    kind
        A key of `slots.KINDS`.
    entries
        The twelve numbers of `slots`.
    frames
        Twelve numbers each (rows of a 3 x 4 matrix) that entries refer to, by the name of a scene's property.
    strength
        Irradiance (any one unit) that it gives where objects stand; the brightest stay where there are too many.
    is_written
        Whether Python has to write it anew on each frame, since no driver can follow it.
    """

    key: Hashable
    name: str
    kind: str
    entries: tuple[Entry, ...]
    frames: dict[str, tuple[Entry, ...]] = field(default_factory=dict)
    strength: float = 0.0
    is_written: bool = False


def follow(owner: bpy.types.ID, path: str) -> Drive:
    """The number at a path of a data-block."""
    return Drive((Variable("value", owner, path),))
