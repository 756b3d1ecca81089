# SPDX-License-Identifier: GPL-3.0-or-later
"""What stays of a mesh while it deforms: which corners meet at a vertex, its triangles and its UV."""

from __future__ import annotations

import weakref
from dataclasses import dataclass, field
from typing import Any

import bpy
import numpy as np


@dataclass(eq=False)
class Topology:
    """A mesh without its places.

    Parameters
    ----------
    corner_vertex
        ``(n,)`` vertices of the corners.
    triangle_face
        ``(m,)`` faces of the triangles.
    slots
        ``(f,)`` material indices of the faces; None where all are 0.
    """

    corner_vertex: np.ndarray
    triangle_face: np.ndarray
    slots: np.ndarray | None
    #: ``(m, 3)`` corners of the triangles, by material slot, and the diagonals of quads that they were cut along.
    triangles: dict[int, np.ndarray] = field(default_factory=dict)
    diagonals: np.ndarray | None = None
    #: Index buffers of `triangles`.
    indices: dict[int, Any] = field(default_factory=dict)
    #: UV of the map that gives the tangents, and the signs that they had for it.
    tangent_uv: np.ndarray | None = None
    signs: np.ndarray | None = None
    #: UV of the map that pictures use, and its buffer.
    picture_uv: np.ndarray | None = None
    picture_buffer: Any = None

    def __post_init__(self) -> None:
        sizes = np.bincount(self.triangle_face) + 2
        self.largest = int(sizes.max(initial=0))
        #: First corners of the quads; None where there are larger faces.
        self.quads = (np.cumsum(sizes) - sizes)[sizes == 4] if self.largest <= 4 else None

    def same(self, corner_vertex: np.ndarray, triangle_face: np.ndarray, slots: np.ndarray | None) -> bool:
        """Whether a mesh is made alike."""
        return (
            np.array_equal(self.corner_vertex, corner_vertex)
            and np.array_equal(self.triangle_face, triangle_face)
            and alike(self.slots, slots)
        )

    def cut(self, mesh: bpy.types.Mesh, places: np.ndarray) -> dict[int, np.ndarray]:
        """The triangles for these places of the corners; those known already where no quad folds the other way."""
        diagonals = self._diagonals(places)
        if self.triangles and diagonals is not None and alike(self.diagonals, diagonals):
            return self.triangles
        corners = read(mesh.loop_triangles, "loops", 3, np.int32)
        if self.slots is None:
            self.triangles = {0: corners}
        else:
            slots = self.slots[self.triangle_face]
            self.triangles = {int(slot): np.ascontiguousarray(corners[slots == slot]) for slot in np.unique(slots)}
        self.diagonals = diagonals
        self.indices = {}
        return self.triangles

    def _diagonals(self, places: np.ndarray) -> np.ndarray | None:
        """Whether each quad is cut between its second and fourth corner: where first and third do not see each other.

        None for meshes with larger faces, which Blender cuts by rules of its own.
        """
        if self.quads is None:
            return None
        if len(places) == 4 * len(self.quads):
            quads = places.reshape(-1, 4, 3)
        else:
            quads = places[self.quads[:, None] + np.arange(4)]
        first = quads[:, 0]
        to_second, to_third, to_fourth = (quads[:, i] - first for i in (1, 2, 3))
        return (_cross(to_second, to_third) * _cross(to_fourth, to_third)).sum(0) > 0.0


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """``(3, n)`` products of ``(n, 3)`` vectors; numpy's own is several times slower."""
    ax, ay, az = a.T
    bx, by, bz = b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


class Topologies:
    """Topologies in use, found again by what they hold."""

    def __init__(self) -> None:
        self._held: dict[tuple[int, int], weakref.WeakSet[Topology]] = {}

    def of(self, mesh: bpy.types.Mesh) -> Topology:
        """The topology of an evaluated mesh: the one known where it only moved."""
        corner_vertex = attribute(mesh, ".corner_vert", "value", np.int32)
        if corner_vertex is None:
            corner_vertex = read(mesh.loops, "vertex_index", 1, np.int32).ravel()
        # Tells the sizes of the faces too, and is read much faster than those.
        triangle_face = read(mesh.loop_triangle_polygons, "value", 1, np.int32).ravel()
        slots = attribute(mesh, "material_index", "value", np.int32)
        if slots is not None and not slots.any():
            slots = None
        same_sizes = self._held.setdefault((len(corner_vertex), len(triangle_face)), weakref.WeakSet())
        for known in same_sizes:
            if known.same(corner_vertex, triangle_face, slots):
                return known
        made = Topology(corner_vertex, triangle_face, slots)
        same_sizes.add(made)
        if len(self._held) > 64:
            self._held = {key: kept for key, kept in self._held.items() if len(kept)}
        return made


def alike(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    """Whether both are missing or hold the same."""
    return b is None if a is None else b is not None and np.array_equal(a, b)


def attribute(mesh: bpy.types.Mesh, name: str, field_name: str, dtype: type) -> np.ndarray | None:
    """``(n,)`` or flat values of an attribute; None where the mesh has none of that name."""
    found = mesh.attributes.get(name)
    if found is None:
        return None
    width = 3 if field_name == "vector" else 1
    values: np.ndarray = np.empty(len(found.data) * width, dtype)
    found.data.foreach_get(field_name, values)
    return values


def read(collection: Any, name: str, width: int, dtype: type = np.float32) -> np.ndarray:
    """``(n, width)`` values of a property."""
    values: np.ndarray = np.empty(len(collection) * width, dtype)
    collection.foreach_get(name, values)
    return values.reshape(-1, width)
