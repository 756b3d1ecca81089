# SPDX-License-Identifier: GPL-3.0-or-later
"""How large an object is, and how much of it one unit of its UV map covers."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from ....precompute.errors import ParameterError


@dataclass(frozen=True)
class Body:
    """A body whose UV map runs along it and once around it.

    Parameters
    ----------
    length_m, girth_m
        What one unit of the map covers, metres; of the girth the mean.
    along_v
        Whether v runs along.
    """

    length_m: float
    girth_m: float
    along_v: bool


def longest_m(ob: bpy.types.Object) -> float:
    """Longest side of an object's box in metres, 0 where it has none; a unit is a metre."""
    return max(ob.dimensions) if hasattr(ob, "dimensions") else 0.0


def uv_map(ob: bpy.types.Object) -> Body:
    """Measure the active UV map of an object as it is now.

    An edge of a face with (du, dv) is ``sqrt((U du)^2 + (V dv)^2)`` long where the map's lines cross at right angles;
    U and V fit all edges in the mean, each weighted by its length.

    Raises
    ------
    ParameterError
        If there is no UV map, or it covers nothing.
    """
    evaluated = ob.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = evaluated.to_mesh() if ob.type in {"MESH", "CURVE", "SURFACE", "FONT", "META"} else None
    try:
        layer = mesh.uv_layers.active if mesh is not None else None
        if mesh is None or layer is None or not len(mesh.loops):
            raise ParameterError(f"{ob.name} has no UV map; unwrap it along its body, or let Space be Object.")
        uv = np.empty(2 * len(mesh.loops), np.float32)
        layer.uv.foreach_get("vector", uv)
        vertex = np.empty(len(mesh.loops), np.int32)
        mesh.loops.foreach_get("vertex_index", vertex)
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        starts, totals = (np.empty(len(mesh.polygons), np.int32) for _ in range(2))
        mesh.polygons.foreach_get("loop_start", starts)
        mesh.polygons.foreach_get("loop_total", totals)
    finally:
        evaluated.to_mesh_clear()
    following = np.arange(len(vertex)) + 1
    following[starts + totals - 1] = starts
    place = (points.reshape(-1, 3) * np.array(ob.matrix_world.to_scale()))[vertex].astype(float)
    squared = ((place[following] - place) ** 2).sum(-1)
    change = (uv.reshape(-1, 2)[following] - uv.reshape(-1, 2)).astype(float) ** 2
    known = squared > 0.0
    weight = 1.0 / np.sqrt(squared[known])
    sides, *_ = np.linalg.lstsq(change[known] * weight[:, None], squared[known] * weight, rcond=None)
    if known.sum() < 2 or not (sides > 0.0).all():
        raise ParameterError(
            f"The UV map of {ob.name} does not run along and around it; unwrap it so, or let Space be Object."
        )
    u, v = (float(side) for side in np.sqrt(sides))
    return Body(max(u, v), min(u, v), v > u)
