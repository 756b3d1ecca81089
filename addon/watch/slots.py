# SPDX-License-Identifier: GPL-3.0-or-later
"""Which material slots of the selection an operator gives a material to."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import bpy

#: Objects whose surface a scan can lie on; hair and point clouds have none.
SURFACES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


@dataclass(frozen=True)
class Slot:
    """A place for a material.

    Parameters
    ----------
    ob
        Its object.
    index
        Of the slot; None where the object has none yet.
    """

    ob: bpy.types.Object
    index: int | None

    @property
    def material(self) -> bpy.types.Material | None:
        """What is in it."""
        return None if self.index is None else self.ob.material_slots[self.index].material

    def give(self, new: bpy.types.Material) -> None:
        """Put a material into it; an object without slots gets one."""
        if self.index is None:
            if not self.ob.material_slots:  # another object of the same data may have got it
                self.ob.data.materials.append(new)
        else:
            self.ob.material_slots[self.index].material = new


def takes_material(ob: bpy.types.Object) -> bool:
    """Whether an object has a surface that can be changed."""
    return ob.type in SURFACES and ob.is_editable and ob.data.is_editable


def why_none(selected: Iterable[bpy.types.Object]) -> str:
    """Why a selection takes no material."""
    if any(ob.type in {"CURVES", "POINTCLOUD", "VOLUME"} for ob in selected):
        return "Hair and point clouds have no place for a scan: select an object with a surface"
    return "Select an object with a surface"


def chosen(targets: Iterable[bpy.types.Object], every: bool) -> list[Slot]:
    """The active slots of objects, or every one."""
    found = []
    for ob in targets:
        count = len(ob.material_slots)
        if count == 0:
            found.append(Slot(ob, None))
        elif every:
            found += [Slot(ob, index) for index in range(count)]
        else:
            found.append(Slot(ob, min(ob.active_material_index or 0, count - 1)))
    return found


def only_active(targets: Iterable[bpy.types.Object]) -> str:
    """Which slots get the material where objects have several, without a full stop; empty where none has."""
    several = [ob for ob in targets if len(ob.material_slots) > 1]
    if not several:
        return ""
    named = [
        f"{_name(ob)} of {ob.name} ({(ob.active_material_index or 0) + 1} of {len(ob.material_slots)})"
        for ob in several
    ]
    more = f" and {len(named) - 2} more" if len(named) > 2 else ""
    return f"Only the active slots: {', '.join(named[:2])}{more}"


def _name(ob: bpy.types.Object) -> str:
    shown = ob.active_material
    return shown.name if shown is not None else "the empty slot"
