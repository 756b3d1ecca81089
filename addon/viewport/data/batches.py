# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes in the memory of the GPU, each kept for as long as something draws it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any
from weakref import WeakValueDictionary

import bpy
import numpy as np

from . import corners
from .orientation import Orientation
from .topology import Topologies, Topology


@dataclass(eq=False)
class MeshBatches:
    """A mesh on the GPU: a batch for each material slot in use."""

    batches: dict[int, Any]
    #: Original ID data-blocks that the mesh comes from, by session uid: if one changes, so does the mesh.
    sources: frozenset[int]
    #: Kept for the mesh that comes after this one, which often has only moved.
    topology: Topology | None


class Meshes:
    """`MeshBatches` by what they show; those that nobody holds any more are freed."""

    def __init__(self) -> None:
        self._held: WeakValueDictionary[tuple, MeshBatches] = WeakValueDictionary()
        self._topologies = Topologies()

    def __len__(self) -> int:
        return len(self._held)

    def get(
        self, ob: bpy.types.Object, owner: bpy.types.Object, orientation: Orientation, key: tuple
    ) -> MeshBatches | None:
        """The mesh of an evaluated object; None if it has no faces. Hold on to it for as long as it is drawn.

        Parameters
        ----------
        owner
            What makes the instance, where it is one; else the object.
        key
            Of `mesh_key`.
        """
        held = self._held.get((*key, orientation))
        if held is None:
            held = self._make(ob, orientation, _sources(ob) | _sources(owner))
            if held is not None:
                self._held[(*key, orientation)] = held
        return held

    def forget(self, changed: set[int] | None = None) -> None:
        """Give up meshes that come from these data-blocks (session uids), or all."""
        for key, held in list(self._held.items()):
            if changed is None or held.sources & changed:
                self._held.pop(key, None)

    def _make(self, ob: bpy.types.Object, orientation: Orientation, sources: frozenset[int]) -> MeshBatches | None:
        mesh = ob.to_mesh()
        try:
            arrays = corners.of(mesh, orientation, self._topologies) if mesh is not None else None
            return MeshBatches(_upload(arrays), sources, arrays.topology) if arrays is not None else None
        finally:
            ob.to_mesh_clear()


def _sources(ob: bpy.types.Object) -> frozenset[int]:
    original = ob.original
    data = original.data
    return frozenset({original.session_uid} | ({data.session_uid} if data is not None else set()))


def mesh_key(ob: bpy.types.Object) -> tuple:
    """What tells an evaluated object's mesh from others; one that shares nothing with it keeps its points elsewhere."""
    data = ob.data
    key = ob.original.session_uid, data.as_pointer()
    if not isinstance(data, bpy.types.Mesh):
        return key
    vertices = data.vertices
    count = len(vertices)
    return (*key, count, len(data.loops), vertices[0].as_pointer()) if count else key


def _upload(arrays: corners.Corners) -> dict[int, Any]:
    import gpu

    # Buffers of one attribute each are copied in one go.
    points = [
        _points(name, values)
        for name, values in (("pos", arrays.places), ("nor", arrays.normals), ("tan", arrays.tangents))
    ]
    topology = arrays.topology
    if topology is None:
        points.append(_points("uv", arrays.uv))
        indices = {slot: _triangles(corners_) for slot, corners_ in arrays.triangles.items()}
    else:
        if topology.picture_buffer is None:
            topology.picture_buffer = _points("uv", arrays.uv)
        points.append(topology.picture_buffer)
        if not topology.indices:
            topology.indices = {slot: _triangles(corners_) for slot, corners_ in arrays.triangles.items()}
        indices = topology.indices
    batches = {}
    for slot, index in indices.items():
        batches[slot] = gpu.types.GPUBatch(type="TRIS", buf=points[0], elem=index)
        for each in points[1:]:
            batches[slot].vertbuf_add(each)
    return batches


def _points(name: str, values: np.ndarray) -> Any:
    import gpu

    form = gpu.types.GPUVertFormat()
    form.attr_add(id=name, comp_type="F32", len=values.shape[1], fetch_mode="FLOAT")
    points = gpu.types.GPUVertBuf(len=len(values), format=form)
    points.attr_fill(name, np.ascontiguousarray(values, np.float32))
    return points


def _triangles(corners_: np.ndarray) -> Any:
    import gpu

    return gpu.types.GPUIndexBuf(type="TRIS", seq=corners_)
