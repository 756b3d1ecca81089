# SPDX-License-Identifier: GPL-3.0-or-later
"""What there is to draw in an evaluated scene: pieces of meshes with a material of ours."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import bpy
from mathutils import Matrix

from ..lights import instances
from ..materials import material
from .data import orientation
from .data.batches import MeshBatches, Meshes, mesh_key

_SURFACES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


@dataclass(frozen=True)
class MadeLamp:
    """A lamp that the depsgraph made, used like an object."""

    name: str
    data: Any
    matrix_world: Matrix


@dataclass(eq=False, slots=True)
class Item:
    """One material slot of one instance."""

    material: bpy.types.Material
    #: Session uid of the material, which is quicker to compare.
    uid: int
    matrix: Matrix
    #: Whether the matrix turns the inside out.
    mirrored: bool
    mesh: MeshBatches
    batch: Any


def gather(
    depsgraph: bpy.types.Depsgraph,
    meshes: Meshes,
    visible: Callable[[bpy.types.Object], bool],
    shown: Callable[[bpy.types.Material], bool],
) -> tuple[list[Item], list[MadeLamp]]:
    """All pieces to draw, instances included, and the lamps that the depsgraph made.

    Parameters
    ----------
    visible
        Whether an original object (of an instance: the one that makes it) is to be drawn.
    shown
        Whether a material of ours is to be drawn.
    """
    ours = {m.session_uid: m for m in bpy.data.materials if material.is_ours(m) and _shown(m) and shown(m)}
    if not ours:
        return [], []
    orientations = {uid: orientation.of(m) for uid, m in ours.items()}
    #: By evaluated object: its slots' materials and its mesh's key; None where it shows nothing of ours.
    known: dict[int, tuple[dict[int, int], tuple] | None] = {}
    found: list[Item] = []
    made: list[MadeLamp] = []
    surfaces = _SURFACES
    for instance in depsgraph.object_instances:
        ob = instance.object
        kind = ob.type
        if kind == "LIGHT":
            maker: Any = instance.parent
            if instances.is_made_lamp(instance) and visible(maker.original):
                made.append(MadeLamp(ob.name, ob.data, instance.matrix_world.copy()))
            continue
        if kind not in surfaces or not instance.show_self:
            continue
        place = ob.as_pointer()
        if place not in known:
            known[place] = _of_ours(ob, ours)
        ours_of = known[place]
        if ours_of is None:
            continue
        used, key = ours_of
        parent = instance.parent if instance.is_instance else None
        owner = ob if parent is None else parent
        if not visible(owner.original):
            continue
        matrix = instance.matrix_world.copy()
        mirrored = matrix.is_negative
        wanted = {orientations[uid] for uid in used.values() if uid in ours}
        last = max(used)
        for orient in wanted:
            mesh = meshes.get(ob, owner, orient, key)
            if mesh is None:
                continue
            for index, batch in mesh.batches.items():
                uid = used.get(min(index, last))
                if uid in ours and orientations[uid] == orient:
                    found.append(Item(ours[uid], uid, matrix, mirrored, mesh, batch))
    found.sort(key=attrgetter("uid"))
    return found, made


def _of_ours(ob: bpy.types.Object, ours: dict[int, bpy.types.Material]) -> tuple[dict[int, int], tuple] | None:
    if ob.display_type in {"WIRE", "BOUNDS"}:
        return None
    used = {i: m.original.session_uid for i, m in enumerate(slots(ob)) if m is not None}
    return None if ours.keys().isdisjoint(used.values()) else (used, mesh_key(ob))


def slots(ob: bpy.types.Object) -> list[bpy.types.Material | None]:
    """Materials of an evaluated object by slot: geometry nodes may have added some to its data."""
    materials = list(getattr(ob.data, "materials", ()))
    known = len(materials)
    for index, slot in enumerate(ob.material_slots):
        if index >= known or slot.link != "DATA":
            materials[index : index + 1] = [slot.material]
    return materials


def _shown(shaded: bpy.types.Material) -> bool:
    settings = getattr(shaded, "diffraction_viewport", None)
    return settings is None or settings.show
