# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of a mesh for drawing: place, normal and tangent of every corner of every triangle's face."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from .orientation import Orientation


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
    """

    places: np.ndarray
    normals: np.ndarray
    tangents: np.ndarray
    uv: np.ndarray
    triangles: dict[int, np.ndarray]


def of(mesh: bpy.types.Mesh, orientation: Orientation) -> Corners | None:
    """Read a mesh; None if it has no faces."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if not count:
        return None
    vertices = _read(mesh.vertices, "co", 3)
    corner_vertex = _read(mesh.loops, "vertex_index", 1, np.int32).ravel()
    normals = _read(mesh.corner_normals, "vector", 3)
    corners = _read(mesh.loop_triangles, "loops", 3, np.int32)
    slots = _read(mesh.loop_triangles, "material_index", 1, np.int32).ravel()
    places = vertices[corner_vertex]
    tangents, unrolled = _tangents(mesh, orientation, vertices, corner_vertex, normals, corners)
    uv = _picture_uv(mesh)
    if unrolled:
        places, normals, uv = (values[corners.ravel()] for values in (places, normals, uv))
        corners = np.arange(3 * count, dtype=np.int32).reshape(-1, 3)
    triangles = {int(slot): np.ascontiguousarray(corners[slots == slot]) for slot in np.unique(slots)}
    return Corners(places, normals, tangents, uv, triangles)


def _picture_uv(mesh: bpy.types.Mesh) -> np.ndarray:
    layer = next((each for each in mesh.uv_layers if each.active_render), None)
    if layer is None:
        return np.zeros((len(mesh.loops), 2), np.float32)
    return _read(layer.uv, "vector", 2)


def _read(collection, name: str, width: int, dtype: type = np.float32) -> np.ndarray:
    values: np.ndarray = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)


def _tangents(mesh, orientation, vertices, corner_vertex, normals, corners) -> tuple[np.ndarray, bool]:
    """``(n, 4)`` tangents, and whether they belong to the corners of triangles rather than those of faces."""
    if orientation.mode == "UV" and mesh.uv_layers:
        layer = mesh.uv_layers.get(orientation.name) if orientation.name else mesh.uv_layers.active
        if layer is not None:
            return _uv_tangents(mesh, layer.name, normals, corners)
    tangents = np.zeros((len(corner_vertex), 4), np.float32)
    if orientation.mode == "ATTRIBUTE":
        values = _attribute(mesh, orientation.name, corner_vertex)
        if values is not None:
            tangents[:, :3] = values
    elif orientation.mode == "RADIAL":
        # Of the Tangent node: round an axis through the middle of the texture space.
        middle = np.array(mesh.texspace_location, np.float32)
        size = np.where(np.array(mesh.texspace_size) == 0.0, 1.0, mesh.texspace_size).astype(np.float32)
        x, y, z = np.moveaxis(0.5 * (vertices - middle) / size, -1, 0)
        zero = np.zeros_like(x)
        around = {"X": (zero, -z, y), "Y": (-z, zero, x), "Z": (-y, x, zero)}[orientation.name or "Z"]
        tangents[:, :3] = np.stack(around, -1)[corner_vertex]
    return tangents, False


def _attribute(mesh: bpy.types.Mesh, name: str, corner_vertex: np.ndarray) -> np.ndarray | None:
    """``(n, 3)`` values of a vector attribute at the corners; None where the mesh has no such attribute."""
    attribute = mesh.attributes.get(name)
    if attribute is None or attribute.data_type != "FLOAT_VECTOR":
        return None
    values = _read(attribute.data, "vector", 3)
    if attribute.domain == "POINT":
        return values[corner_vertex]
    if attribute.domain == "CORNER":
        return values
    if attribute.domain == "FACE":
        totals = _read(mesh.polygons, "loop_total", 1, np.int32).ravel()
        return np.repeat(values, totals, axis=0)
    return None


def _uv_tangents(mesh, uv_name, normals, corners) -> tuple[np.ndarray, bool]:
    if int(_read(mesh.polygons, "loop_total", 1, np.int32).max()) <= 4:
        return _mikk(mesh, uv_name), False
    # Blender computes tangents of triangles and quads only.
    uv = _read(mesh.uv_layers[uv_name].uv, "vector", 2)
    vertex = _read(mesh.loops, "vertex_index", 1, np.int32).ravel()
    places = _read(mesh.vertices, "co", 3)[vertex]
    return triangle_tangents(places[corners], normals[corners], uv[corners]), True


def _mikk(mesh: bpy.types.Mesh, uv_name: str) -> np.ndarray:
    mesh.calc_tangents(uvmap=uv_name)
    tangents = np.empty((len(mesh.loops), 4), np.float32)
    tangents[:, :3] = _read(mesh.loops, "tangent", 3)
    tangents[:, 3] = _read(mesh.loops, "bitangent_sign", 1).ravel()
    mesh.free_tangents()
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
    _, group = np.unique(like, axis=0, return_inverse=True)
    group = group.ravel()
    total = np.zeros((group.max() + 1, 3))
    np.add.at(total, group, (along * angle[..., None]).reshape(-1, 3))
    tangents = np.empty((len(group), 4), np.float32)
    tangents[:, :3] = _unit(total)[group]
    tangents[:, 3] = np.repeat(sign, 3)
    return tangents


def _flat_unit(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    return _unit(vectors - (vectors * normals).sum(-1, keepdims=True) * normals)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-20)
