# SPDX-License-Identifier: GPL-3.0-or-later
"""A light as it enters the scene's list: numbers, or what a driver makes them from."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field

import bpy


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
    """

    key: Hashable
    name: str
    kind: str
    entries: tuple[Entry, ...]
    frames: dict[str, tuple[Entry, ...]] = field(default_factory=dict)
    strength: float = 0.0

    @property
    def is_written(self) -> bool:
        """Whether Python has to write it anew on each frame."""
        return not any(isinstance(entry, Drive) for entry in self.entries)


def follow(owner: bpy.types.ID, path: str) -> Drive:
    """The number at a path of a data-block."""
    return Drive((Variable("value", owner, path),))
