# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of a mesh for drawing: place, normal and tangent of every corner of every triangle's face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from .orientation import Orientation
from .topology import Topologies, Topology, alike, attribute, read


@dataclass
class Corners:
    """A mesh ready to draw.

    Parameters
    ----------
    places, normals
        ``(n, 3)`` in object space.
    tangents
        ``(n, 4)``: along the scan's x in object space, not of unit length where it is interpolated; last the sign of
        the bitangent (0: right-handed). Zero where the mesh does not tell.
    uv
        ``(n, 2)`` of the map that pictures use.
    triangles
        ``(m, 3)`` corners, by material slot.
    topology
        Whose corners and triangles these are; None where every triangle has corners of its own.
    """

    places: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray
    uv: np.ndarray
    triangles: dict[int, np.ndarray]
    topology: Topology | None


def of(mesh: bpy.types.Mesh, orientation: Orientation, topologies: Topologies) -> Corners | None:
    """Read a mesh; None if it has no faces."""
    mesh.calc_loop_triangles()
    if not len(mesh.loop_triangles):
        return None
    topology = topologies.of(mesh)
    position = attribute(mesh, "position", "vector", np.float32)
    vertices = position.reshape(-1, 3) if position is not None else read(mesh.vertices, "co", 3)
    normals = read(mesh.corner_normals, "vector", 3)
    places = vertices[topology.corner_vertex]
    triangles = topology.cut(mesh, places)
    uv = _picture_uv(mesh, topology)
    layer = _tangent_layer(mesh, orientation)
    if layer is not None and topology.quads is None:
        # Blender computes tangents of triangles and quads only.
        slots = np.repeat(list(triangles), [len(each) for each in triangles.values()])
        corners = np.concatenate(list(triangles.values()))
        map_uv = read(layer.uv, "vector", 2)
        tangents = triangle_tangents(places[corners], normals[corners], map_uv[corners])
        places, normals, uv = (values[corners.ravel()] for values in (places, normals, uv))
        own = np.arange(len(places), dtype=np.int32).reshape(-1, 3)
        return Corners(places, normals, tangents, uv, {int(s): own[slots == s] for s in triangles}, None)
    if layer is not None:
        tangents = _mikk(mesh, layer, topology)
    else:
        tangents = _other_tangents(mesh, orientation, vertices, topology.corner_vertex)
    return Corners(places, normals, tangents, uv, triangles, topology)


def _picture_uv(mesh: bpy.types.Mesh, topology: Topology) -> np.ndarray:
    layer = next((each for each in mesh.uv_layers if each.active_render), None)
    if layer is None:
        uv = np.zeros((len(topology.corner_vertex), 2), np.float32)
    else:
        uv = read(layer.uv, "vector", 2)
    if not alike(topology.picture_uv, uv):
        topology.picture_uv, topology.picture_buffer = uv, None
    return uv


def _tangent_layer(mesh: bpy.types.Mesh, orientation: Orientation) -> Any:
    """The UV map that tells where the scan's x goes, where that is the orientation."""
    if orientation.mode != "UV" or not mesh.uv_layers:
        return None
    return mesh.uv_layers.get(orientation.name) if orientation.name else mesh.uv_layers.active


def _other_tangents(
    mesh: bpy.types.Mesh, orientation: Orientation, vertices: np.ndarray, corner_vertex: np.ndarray
) -> np.ndarray:
    """``(n, 4)`` tangents that come from no UV map."""
    tangents = np.zeros((len(corner_vertex), 4), np.float32)
    if orientation.mode == "ATTRIBUTE":
        values = _attribute(mesh, orientation.name, corner_vertex)
        if values is not None:
            tangents[:, :3] = values
    elif orientation.mode == "RADIAL":
        # Of the Tangent node: round an axis through the middle of the texture space.
        middle = np.array(mesh.texspace_location, np.float32)
        size = np.array(mesh.texspace_size, np.float32)
        size[size == 0.0] = 1.0
        x, y, z = np.moveaxis(0.5 * (vertices - middle) / size, -1, 0)
        zero = np.zeros_like(x)
        around = {"X": (zero, -z, y), "Y": (-z, zero, x), "Z": (-y, x, zero)}[orientation.name or "Z"]
        tangents[:, :3] = np.stack(around, -1)[corner_vertex]
    return tangents


def _attribute(mesh: bpy.types.Mesh, name: str, corner_vertex: np.ndarray) -> np.ndarray | None:
    """``(n, 3)`` values of a vector attribute at the corners; None where the mesh has no such attribute."""
    found = mesh.attributes.get(name)
    if found is None or found.data_type != "FLOAT_VECTOR":
        return None
    values = read(found.data, "vector", 3)
    if found.domain == "POINT":
        return values[corner_vertex]
    if found.domain == "CORNER":
        return values
    if found.domain == "FACE":
        totals = read(mesh.polygons, "loop_total", 1, np.int32).ravel()
        return np.repeat(values, totals, axis=0)
    return None


def _mikk(mesh: bpy.types.Mesh, layer: Any, topology: Topology) -> np.ndarray:
    uv = read(layer.uv, "vector", 2)
    mesh.calc_tangents(uvmap=layer.name)
    try:
        tangents = np.empty((len(topology.corner_vertex), 4), np.float32)
        tangents[:, :3] = read(mesh.loops, "tangent", 3)
        # Signs follow the UV alone, and cost as much to read as the tangents.
        if topology.signs is None or not alike(topology.tangent_uv, uv):
            topology.tangent_uv, topology.signs = uv, read(mesh.loops, "bitangent_sign", 1).ravel()
    finally:
        mesh.free_tangents()
    tangents[:, 3] = topology.signs
    return tangents


def triangle_tangents(places: np.ndarray, normals: np.ndarray, uv: np.ndarray) -> np.ndarray:
    """Tangents of triangles, smoothed over corners of the same place, normal and UV.

    The rules of MikkTSpace: each triangle's tangent is projected on the corner's plane and weighted with the angle
    that its edges enclose there; mirrored and unmirrored triangles do not mix.

    Parameters
    ----------
    places, normals
        ``(m, 3, 3)``: triangles, corners, components.
    uv
        ``(m, 3, 2)``.

    Returns
    -------
    ndarray
        ``(3 m, 4)`` unit tangents and the sign of the bitangent.
    """
    e1, e2 = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    d1, d2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
    sign = np.where(area < 0.0, -1.0, 1.0).astype(np.float32)
    along = sign[:, None] * (e1 * d2[:, 1:] - e2 * d1[:, 1:])
    along = _flat_unit(np.repeat(along[:, None], 3, axis=1), normals)
    following = _flat_unit(np.roll(places, -1, axis=1) - places, normals)
    previous = _flat_unit(np.roll(places, 1, axis=1) - places, normals)
    angle = np.arccos(np.clip((following * previous).sum(-1), -1.0, 1.0))
    like = np.concatenate([places, normals, uv, np.repeat(sign[:, None, None], 3, axis=1)], axis=-1).reshape(-1, 9)
    group = _alike(like.astype(np.float32))
    total = np.zeros((group.max() + 1, 3))
    np.add.at(total, group, (along * angle[..., None]).reshape(-1, 3))
    tangents = np.empty((len(group), 4), np.float32)
    tangents[:, :3] = _unit(total)[group]
    tangents[:, 3] = np.repeat(sign, 3)
    return tangents


def _alike(rows: np.ndarray) -> np.ndarray:
    """``(n,)`` numbers of the groups of equal rows: by a 64-bit hash of each, which sorts faster than rows."""
    bits = np.ascontiguousarray(rows + np.float32(0.0)).view(np.uint32)  # -0 counts as 0
    key = np.zeros(len(rows), np.uint64)
    for column in bits.T:
        key = (key ^ column) * np.uint64(0x9E3779B97F4A7C15)
        key ^= key >> np.uint64(29)
    return np.unique(key, return_inverse=True)[1].ravel()


def _flat_unit(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    return _unit(vectors - (vectors * normals).sum(-1, keepdims=True) * normals)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-20)
