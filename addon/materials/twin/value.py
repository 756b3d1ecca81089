# SPDX-License-Identifier: GPL-3.0-or-later
"""f cos of one direction of light as a node group, the same formulas as ``shaders/brdf.osl``."""

from __future__ import annotations

import bpy

from ....precompute.table.layout import TableLayout
from ..node_graph import Graph, Socket, Value, interface, new_group
from . import lookup

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"


def value(name: str, layout: TableLayout, table: bpy.types.NodeTree, fresnel: str) -> bpy.types.NodeTree:
    """Group that gives f cos(theta_i) R as RGB, but for the factor ``scale / (4 cos_r)`` that all directions share.

    With h = wi + wr = -(u, v, w) it is ``(1 + wi.wr)^2 / (cos_r w^2) T R``, ``1 + wi.wr = |h|^2 / 2`` and the cosine of
    the half-angle is ``|h| / 2``. Inputs: |(u, v)|^2, the angle of (-u, -v), |w|; rows of the matrix to the working
    space; R0 of a dielectric, or n and k; 1 in EEVEE.
    """
    tree = new_group(f"Diffraction value {name} {fresnel.lower()}")
    sockets: dict[str, tuple[str, object]] = {each: (_FLOAT, None) for each in ("Square", "Turn", "W")}
    sockets |= {each: (_VECTOR, None) for each in ("Red", "Green", "Blue")}
    sockets |= {"R0": (_FLOAT, None)} if fresnel == "DIELECTRIC" else {}
    sockets |= {each: (_VECTOR, None) for each in ("ConductorN", "ConductorK")} if fresnel == "CONDUCTOR" else {}
    interface(tree, sockets | {"EEVEE": (_FLOAT, 0.0)}, {"Value": _VECTOR})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    square, w = given["Square"], given["W"]
    xyz = graph.group(table, Square=square, Turn=given["Turn"], W=w, EEVEE=given["EEVEE"]).outputs["Value"]
    rgb = _into_gamut(graph, xyz, [given[each] for each in ("Red", "Green", "Blue")])
    h2 = graph.fused(w, w, square)
    factor = graph.quotient(graph.product(h2, h2), w)
    more = lookup.gain(graph, layout, w)
    if more is not None:
        factor = graph.product(factor, more)
    if fresnel != "NONE":
        h = graph.math("SQRT", h2)
        if fresnel == "DIELECTRIC":
            factor = graph.product(factor, dielectric(graph, given["R0"], graph.fused(h, -0.5, 1.0)))
        else:
            cos_half = graph.product(h, 0.5)
            rgb = graph.vector("MULTIPLY", rgb, conductor(graph, given["ConductorN"], given["ConductorK"], cos_half))
    graph.put(graph.add("NodeGroupOutput").inputs["Value"], graph.scaled(rgb, factor))
    return tree


def _into_gamut(graph: Graph, xyz: Socket, rows: list[Socket]) -> Socket:
    """As ``into_gamut`` in ``shaders/brdf.osl``: towards the grey of its luminance until no component is negative."""
    rgb = [graph.scalar("DOT_PRODUCT", row, xyz) for row in rows]
    luminance = graph.scalar("DOT_PRODUCT", xyz, (0.0, 1.0, 0.0))
    below = graph.math("MINIMUM", graph.math("MINIMUM", graph.math("MINIMUM", rgb[0], rgb[1]), rgb[2]), 0.0)
    keep = graph.quotient(luminance, graph.difference(luminance, below))  # 1 inside the gamut
    moved = graph.mix(keep, luminance, graph.join(*rgb))
    return graph.vector("MAXIMUM", moved, (0.0, 0.0, 0.0))


def dielectric(graph: Graph, r0: Value, rest: Socket) -> Socket:
    """Schlick's reflectance, from 1 - cos(half)."""
    return graph.fused(graph.difference(1.0, r0), graph.math("POWER", rest, 5.0), r0)


def conductor(graph: Graph, n: Socket, k: Socket, cos_half: Socket) -> Socket:
    """As ``fresnel_conductor`` in ``shaders/brdf.osl``, a vector."""
    n, k = graph.split(n), graph.split(k)
    c = graph.clamp(cos_half, 0.0, 1.0)
    c2 = graph.product(c, c)
    s2 = graph.difference(1.0, c2)
    return graph.join(*(_conductor(graph, n[i], k[i], c, c2, s2) for i in range(3)))


def _conductor(graph: Graph, n: Socket, k: Socket, c: Socket, c2: Socket, s2: Socket) -> Socket:
    d = graph.difference(graph.difference(graph.product(n, n), graph.product(k, k)), s2)
    nk = graph.product(n, k)
    a2b2 = graph.math("SQRT", graph.fused(d, d, graph.product(nk, nk, 4.0)))
    a = graph.math("SQRT", graph.product(graph.sum(a2b2, d), 0.5))
    twice = graph.product(c, a, 2.0)
    plain = graph.sum(a2b2, c2)
    rs = graph.quotient(graph.difference(plain, twice), graph.sum(plain, twice))
    p_plain, p_twice = graph.fused(c2, a2b2, graph.product(s2, s2)), graph.product(twice, s2)
    rp = graph.product(rs, graph.quotient(graph.difference(p_plain, p_twice), graph.sum(p_plain, p_twice)))
    return graph.product(graph.sum(rs, rp), 0.5)
