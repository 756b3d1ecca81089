# SPDX-License-Identifier: GPL-3.0-or-later
"""f cos of one direction of light as a node group, the same formulas as ``shaders/brdf.osl``."""

from __future__ import annotations

from typing import Any

import bpy

from ....precompute.constants import LEAST_REFLECTANCE
from ....precompute.table.layout import TableLayout
from ..node_graph import Graph, Socket, Value, interface, new_group, shared_group
from . import lookup

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"

#: Sockets that tell the index of what reflects.
INDICES = {"NONE": (), "SCHLICK": ("R0",), "DIELECTRIC": ("IOR",), "CONDUCTOR": ("ConductorN", "ConductorK")}


def value(
    name: str, layout: TableLayout, table: bpy.types.NodeTree, fresnel: str, kept: bpy.types.NodeTree | None = None
) -> bpy.types.NodeTree:
    """Group that gives f cos(theta_i) R, an RGB and a factor of it, but for the factor that all directions share,
    ``scale / (4 cos_r)`` times ``s^2 q^power`` of a painted surface.

    With h = wi + wr = -(u, v, w) it is ``(1 + wi.wr)^2 / (cos_r w^2) T R``, ``1 + wi.wr = |h|^2 / 2`` and the cosine of
    the half-angle is ``|h| / 2``. Inputs: |(u, v)| and its square, the angle of (-u, -v), |w|; h, of any length; s, s^2
    and q; rows of the matrix to the working space; IOR or R0 of a dielectric, or n and k; 1 in EEVEE; a random number
    where the table's group has one.
    """
    at_random = "Xi" in table.interface.items_tree
    tree = new_group(f"Diffraction value {name} {fresnel.lower()}{' at random' if at_random else ''}")
    sockets: dict[str, tuple[str, object]] = {
        each: (_FLOAT, None) for each in ("Radius", "Square", "Turn", "W", "Scale", "Scale2", "Depth", "IsScaled")
    }
    sockets |= {each: (_VECTOR, None) for each in ("Red", "Green", "Blue", "Half")}
    sockets |= {each: (_VECTOR if fresnel == "CONDUCTOR" else _FLOAT, None) for each in INDICES[fresnel]}
    sockets |= {"Xi": (_FLOAT, None)} if at_random else {}
    interface(tree, sockets | {"EEVEE": (_FLOAT, 0.0)}, {"Value": _VECTOR, "Factor": _FLOAT})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    square, w = given["Square"], given["W"]
    places = {"Radius": graph.product(given["Radius"], given["Scale"])}
    places |= {"Square": graph.product(square, given["Scale2"]), "W": graph.product(w, given["Depth"])}
    places |= {"Xi": given["Xi"]} if at_random else {}
    found = graph.group(table, Turn=given["Turn"], EEVEE=given["EEVEE"], **places).outputs
    xyz = found["Value"]
    if kept is not None and layout.index == 1.0:
        xyz = _corrected(graph, kept, given, xyz)
    rgb = _into_gamut(graph, xyz, [given[each] for each in ("Red", "Green", "Blue")])
    h2 = graph.fused(w, w, square)
    factor = graph.product(graph.quotient(graph.product(h2, h2), w), found["Factor"])
    more = lookup.gain(graph, layout, w)
    if more is not None:
        factor = graph.product(factor, more)
    if fresnel == "DIELECTRIC":
        factor = graph.product(factor, dielectric(graph, given["IOR"], graph.vector("NORMALIZE", given["Half"])))
    elif fresnel != "NONE":
        h = graph.math("SQRT", h2)
        cos_half = graph.product(h, 0.5)
        if fresnel == "SCHLICK":
            factor = graph.product(factor, schlick(graph, given["R0"], graph.fused(h, -0.5, 1.0)))
        else:
            rgb = graph.vector("MULTIPLY", rgb, conductor(graph, given["ConductorN"], given["ConductorK"], cos_half))
    out = graph.add("NodeGroupOutput").inputs
    graph.put(out["Value"], rgb)
    graph.put(out["Factor"], factor)
    return tree


def _corrected(graph: Graph, kept: bpy.types.NodeTree, given: Any, xyz: Socket) -> Socket:
    """The reflectance of a stack inside, of a painted surface, at the true half-angle, see ``shaders/brdf.osl``."""
    square, w2 = given["Square"], graph.product(given["W"], given["W"])
    depth2 = graph.product(given["Depth"], given["Depth"])
    sums = (graph.sum(square, w2), graph.fused(square, given["Scale2"], graph.product(w2, depth2)))
    own, taken = (
        graph.group(
            kept, Cosine=graph.math("MINIMUM", graph.product(graph.math("SQRT", each), 0.5), 1.0), EEVEE=given["EEVEE"]
        ).outputs["XYZ"]
        for each in sums
    )
    taken = graph.vector("MAXIMUM", taken, (LEAST_REFLECTANCE,) * 3)
    more = graph.vector("SUBTRACT", graph.vector("DIVIDE", own, taken), (1.0, 1.0, 1.0))
    # A product with 0 is dropped where nothing is painted.
    return graph.vector("MULTIPLY_ADD", graph.scaled(more, given["IsScaled"]), xyz, xyz)


def _into_gamut(graph: Graph, xyz: Socket, rows: list[Socket]) -> Socket:
    """As ``into_gamut`` in ``shaders/brdf.osl``: towards the grey of its luminance until no component is negative."""
    rgb = [graph.scalar("DOT_PRODUCT", row, xyz) for row in rows]
    luminance = graph.split(xyz)[1]
    below = graph.math("MINIMUM", graph.math("MINIMUM", graph.math("MINIMUM", rgb[0], rgb[1]), rgb[2]), 0.0)
    # 1 inside the gamut; outside a millionth less than would do, so that no rounding leaves a component below 0.
    keep = graph.quotient(luminance, graph.fused(below, -1.000001, luminance))
    return graph.mix(keep, luminance, graph.join(*rgb))


def schlick(graph: Graph, r0: Value, rest: Socket) -> Socket:
    """Schlick's approximation, from 1 - cos(half)."""
    return graph.fused(graph.difference(1.0, r0), graph.math("POWER", rest, 5.0), r0)


def dielectric(graph: Graph, ior: Value, normal: Socket) -> Socket:
    """Reflectance towards the viewer of a face with a unit normal, as `exact`; within, it is that of the index 1 / n.

    One node of Cycles' own in place of fifteen.
    """
    node = graph.add("ShaderNodeFresnel")
    graph.put(node.inputs["IOR"], ior)
    graph.put(node.inputs["Normal"], normal)
    return node.outputs[0]


def exact(graph: Graph, n2: Value, cosine: Socket) -> Socket:
    """Reflectance of a face to a medium of squared index n2: ``fresnel_exact`` in ``shaders/brdf.osl``."""
    c = graph.clamp(cosine, 1e-6, 1.0)
    inside = graph.math("SQRT", graph.fused(c, c, graph.difference(n2, 1.0)))
    s = graph.quotient(graph.difference(c, inside), graph.sum(c, inside))
    dense = graph.product(c, n2)
    p = graph.quotient(graph.difference(dense, inside), graph.sum(dense, inside))
    return graph.product(graph.fused(s, s, graph.product(p, p)), 0.5)


def conductor(graph: Graph, n: Socket, k: Socket, cos_half: Socket) -> Socket:
    """As ``fresnel_conductor`` in ``shaders/brdf.osl``, a vector."""
    inputs = {"N": (_FLOAT, None), "K": (_FLOAT, None), "Cosine": (_FLOAT, None)}
    tree = shared_group("Diffraction conductor", inputs, {"Reflectance": _FLOAT}, _conductor)
    each_n, each_k = graph.split(n), graph.split(k)
    c = graph.clamp(cos_half, 0.0, 1.0)
    return graph.join(*(graph.group(tree, N=each_n[i], K=each_k[i], Cosine=c).outputs["Reflectance"] for i in range(3)))


def _conductor(graph: Graph, given: Any, wanted: Any) -> None:
    n, k, c = given["N"], given["K"], given["Cosine"]
    c2 = graph.product(c, c)
    s2 = graph.difference(1.0, c2)
    d = graph.difference(graph.difference(graph.product(n, n), graph.product(k, k)), s2)
    nk = graph.product(n, k)
    a2b2 = graph.math("SQRT", graph.fused(d, d, graph.product(nk, nk, 4.0)))
    a = graph.math("SQRT", graph.product(graph.sum(a2b2, d), 0.5))
    twice = graph.product(c, a, 2.0)
    plain = graph.sum(a2b2, c2)
    rs = graph.quotient(graph.difference(plain, twice), graph.sum(plain, twice))
    p_plain, p_twice = graph.fused(c2, a2b2, graph.product(s2, s2)), graph.product(twice, s2)
    rp = graph.product(rs, graph.quotient(graph.difference(p_plain, p_twice), graph.sum(p_plain, p_twice)))
    graph.put(wanted["Reflectance"], graph.product(graph.sum(rs, rp), 0.5))
