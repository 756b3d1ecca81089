# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of the file's materials, and those that are missing, damaged or of another release."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import bpy

from ..materials import material, travel
from ..tables.table_state import READY, table_state


def tables() -> dict[Path, list[bpy.types.Material]]:
    """Materials of ours by the place where their table belongs."""
    found: dict[Path, list[bpy.types.Material]] = {}
    for each in material.of_file():
        found.setdefault(travel.home(each), []).append(each)
    return found


def problems() -> Iterator[tuple[bpy.types.Material, str]]:
    """Materials whose table cannot be read, and why."""
    for users in tables().values():
        for each in users:
            found = table_state(material.table_path(each))
            if found.kind != READY:
                yield each, found.text
