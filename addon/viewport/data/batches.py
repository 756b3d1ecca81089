# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in the memory of the GPU, each kept for as long as something draws it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakValueDictionary

import bpy

from . import corners
from .orientation import Orientation


@dataclass(eq=False)
class MeshBatches:
    """A mesh on the GPU: a batch for each material slot in use."""

    batches: dict[int, Any]
    #: Original ID data-blocks that the mesh comes from, by session uid: if one changes, so does the mesh.
    sources: frozenset[int]


class Meshes:
    """`MeshBatches` by what they show; those that nobody holds any more are freed."""

    def __init__(self) -> None:
        self._held: WeakValueDictionary[tuple, MeshBatches] = WeakValueDictionary()

    def __len__(self) -> int:
        return len(self._held)

    def get(self, instance: bpy.types.DepsgraphObjectInstance, orientation: Orientation) -> MeshBatches | None:
        """The mesh of an instance; None if it has no faces. Hold on to it for as long as it is drawn."""
        ob = instance.object
        owner = instance.parent if instance.is_instance and instance.parent is not None else ob
        sources = _sources(ob) | _sources(owner)
        key = (ob.original.session_uid, ob.data.as_pointer(), *_fingerprint(ob), orientation)
        held = self._held.get(key)
        if held is None:
            held = _make(ob, orientation, sources)
            if held is not None:
                self._held[key] = held
        return held

    def forget(self, changed: set[int] | None = None) -> None:
        """Give up meshes that come from these data-blocks (session uids), or all."""
        for key, held in list(self._held.items()):
            if changed is None or held.sources & changed:
                self._held.pop(key, None)


def _sources(ob: bpy.types.Object) -> frozenset[int]:
    original = ob.original
    data = original.data
    return frozenset({original.session_uid} | ({data.session_uid} if data is not None else set()))


def _fingerprint(ob: bpy.types.Object) -> tuple:
    """Where the evaluated mesh keeps its points: a new evaluation that shares nothing with the old one has others."""
    data = ob.data
    if not isinstance(data, bpy.types.Mesh) or not len(data.vertices):
        return ()
    return len(data.vertices), len(data.loops), data.vertices[0].as_pointer()


def _make(ob: bpy.types.Object, orientation: Orientation, sources: frozenset[int]) -> MeshBatches | None:
    mesh = ob.to_mesh()
    try:
        arrays = corners.of(mesh, orientation) if mesh is not None else None
    finally:
        ob.to_mesh_clear()
    return MeshBatches(_upload(arrays), sources) if arrays is not None else None


def _upload(arrays: corners.Corners) -> dict[int, Any]:
    import gpu

    form = gpu.types.GPUVertFormat()
    for name, width in (("pos", 3), ("nor", 3), ("tan", 4), ("uv", 2)):
        form.attr_add(id=name, comp_type="F32", len=width, fetch_mode="FLOAT")
    points = gpu.types.GPUVertBuf(len=len(arrays.places), format=form)
    columns = {"pos": arrays.places, "nor": arrays.normals, "tan": arrays.tangents, "uv": arrays.uv}
    for name, values in columns.items():
        points.attr_fill(name, values)
    return {
        slot: gpu.types.GPUBatch(type="TRIS", buf=points, elem=gpu.types.GPUIndexBuf(type="TRIS", seq=triangles))
        for slot, triangles in arrays.triangles.items()
    }
