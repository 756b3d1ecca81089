# SPDX-License-Identifier: GPL-3.0-or-later
"""The table's lookups as node groups, the same formulas as ``shaders/table.osl``, written for few nodes.

A node costs Cycles a few nanoseconds a sample, a constant nearly as much as an operation, a vector put together or
taken apart three. So logarithms have a base that brings the factor with them, coordinates are fractions of the atlas
from the start, and angles are counted from the negative u axis, where the arc tangent begins.
"""

from __future__ import annotations

import math

import bpy

from ....precompute.table import importance, scaled_albedo
from ....precompute.table.layout import GUARD, GUARD_TOLERANCE, TableLayout
from ..node_graph import Graph, Socket, Value, interface, new_group

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"


def texels(image: bpy.types.Image, size: tuple[int, int], engine: str = "") -> bpy.types.NodeTree:
    """Group (place as fractions of the atlas, 1 in EEVEE) -> texel, bilinear.

    Cycles takes a linear Image Texture. EEVEE would take smaller copies of the atlas where the picture is coarse, and
    mix tiles that have nothing to do with each other: there four closest texels are blended here.

    Parameters
    ----------
    image, size
        Of the table; width and height.
    engine
        ``Cycles`` or ``EEVEE`` where only one of them looks; else the group has both branches, and Cycles drops the
        other one, whose factor it knows to be 0.
    """
    tree = new_group(f"Diffraction texels {image.name} {engine}".rstrip())
    interface(tree, {"Place": (_VECTOR, None), "EEVEE": (_FLOAT, 0.0)}, {"Value": _VECTOR})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    if engine == "Cycles":
        value = _fetch(graph, image, "Linear", given["Place"])
    elif engine == "EEVEE":
        value = _blended(graph, image, size, given["Place"])
    else:
        blended = _blended(graph, image, size, given["Place"])
        value = graph.mix(given["EEVEE"], _linear(graph, image, given["Place"], given["EEVEE"]), blended)
    graph.put(graph.add("NodeGroupOutput").inputs["Value"], value)
    return tree


def _fetch(graph: Graph, image: bpy.types.Image, interpolation: str, place: Socket) -> Socket:
    # Past the right edge the next tile begins at the left: see `transform`.
    node = graph.add("ShaderNodeTexImage", image=image, interpolation=interpolation, extension="REPEAT")
    graph.put(node.inputs["Vector"], place)
    return node.outputs["Color"]


def _linear(graph: Graph, image: bpy.types.Image, place: Socket, in_eevee: Socket) -> Socket:
    """A linear lookup, which Cycles alone takes.

    EEVEE looks up both and chooses after. Without a GPU, places that differ from pixel to pixel as a random direction's
    do take it minutes, since it filters all that lies between them: there the place is one for all. Cycles leaves out
    what is multiplied by 1.
    """
    kept: Value = graph.difference(1.0, in_eevee)
    return _fetch(graph, image, "Linear", graph.vector("MULTIPLY", place, kept))


def _blended(graph: Graph, image: bpy.types.Image, sides: tuple[int, int], place: Socket) -> Socket:
    size = (float(sides[0]), float(sides[1]), 1.0)
    at = graph.vector("MULTIPLY_ADD", place, size, (-0.5, -0.5, 0.0))
    corner = graph.vector("FLOOR", at)
    part = graph.split(graph.vector("SUBTRACT", at, corner))
    rows = []
    for up in (0.5, 1.5):
        pair = [
            _fetch(graph, image, "Closest", graph.vector("DIVIDE", graph.vector("ADD", corner, (right, up, 0.0)), size))
            for right in (0.5, 1.5)
        ]
        rows.append(graph.mix(part[0], *pair))
    return graph.mix(part[1], *rows)


def guard(
    graph: Graph, image: bpy.types.Image, x: float, y: float, width: float, height: float, in_eevee: Socket
) -> Socket:
    """1 where a texel in the middle of a guard holds what was written there, 0 where the renderer got another image."""
    place = graph.join((x + 0.5) / width, (y + 0.5) / height, 0.0)
    # EEVEE would take a smaller copy of the image, of which it knows no derivative here.
    texel = graph.mix(in_eevee, *(_fetch(graph, image, kind, place) for kind in ("Linear", "Closest")))
    off = graph.scalar("DISTANCE", texel, GUARD)
    return graph.math("LESS_THAN", off, GUARD_TOLERANCE)


def _arsinh(graph: Graph, x: Socket, x2: Socket, scale: float, per_unit: float, less: float = 0.0) -> Socket:
    """per_unit (arsinh(x / scale) - less), from x and its square: base and argument of the logarithm bring the rest."""
    k = math.exp(-less) / scale
    root = graph.math("SQRT", graph.fused(x2, k * k, math.exp(-2.0 * less)))
    return graph.math("LOGARITHM", graph.fused(x, k, root), math.exp(1.0 / per_unit))


def transform(
    name: str, layout: TableLayout, found: bpy.types.NodeTree, at_random: bool = False
) -> bpy.types.NodeTree:  # fmt: skip
    """Group (|(u, v)| and its square, angle of (-u, -v), |w|, 1 in EEVEE) -> XYZ of T / scale / |w|^power, a factor.

    The angle lies between -pi and pi. What is left out is left to the caller, see `gain`; the factor, a number, is not
    multiplied in yet.

    Between two slices of |w| the table is linear. A direction that is drawn anyway takes one of the two (``at_random``,
    by a random number ``Xi``), each as often as it counts: the same mean for half the lookups.
    """
    tree = new_group(f"Diffraction table {name}{' at random' if at_random else ''}")
    names = ("Radius", "Square", "Turn", "W", *(("Xi",) if at_random else ()))
    sockets = {each: (_FLOAT, None) for each in names} | {"EEVEE": (_FLOAT, 0.0)}
    interface(tree, sockets, {"Value": _VECTOR, "Factor": _FLOAT})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    turn, w = given["Turn"], given["W"]
    width, height = float(layout.width), float(layout.height)

    column = _arsinh(graph, given["Radius"], given["Square"], layout.r0, layout.a_r)
    # A little less than the last column: a rounding error would blend in the next tile's peak.
    column = graph.math("MINIMUM", column, layout.n_r - 1.02)
    x = graph.fused(column, 1.0 / width, 0.5 / width)
    # phi = angle + pi in (0, 2 pi]; the row after the last one repeats the first.
    y = graph.fused(turn, layout.n_phi / (2.0 * math.pi * height), (1.5 + 0.5 * layout.n_phi) / height)
    position = _arsinh(graph, w, graph.product(w, w), layout.w0, layout.a_w, layout.s_w)
    # Between the first two slices it is that of 1 / |w|: a constant T, as a mirror has it, stays so.
    over = graph.quotient(layout.w_min, w)
    first = graph.clamp(graph.fused(over, -layout.first_share, layout.first_share), 0.0, 1.0)
    if at_random:
        # A little less than the last slice: a sum with 0.9999999 would be rounded up to the one after it.
        position = graph.clamp(position, first, layout.n_w - 1.0 - 1e-5)
        lower = graph.math("FLOOR", graph.sum(position, given["Xi"]))
    else:
        position = graph.clamp(position, first, layout.n_w - 1.0)
        lower = graph.math("MINIMUM", graph.math("FLOOR", position), layout.n_w - 2.0)
    columns, step = float(layout.tile_columns), layout.tile_height / height
    steps = (0.0,) if at_random else (0.0, 1.0)
    if layout.width == layout.tile_columns * layout.n_r:  # tiles fill the atlas: its repetition wraps the columns
        x = graph.fused(lower, layout.n_r / width, x)
        across = [x, *(graph.sum(x, each * layout.n_r / width) for each in steps[1:])]
    else:
        across = [
            graph.fused(graph.math("MODULO", graph.sum(lower, each), columns), layout.n_r / width, x) for each in steps
        ]
    values = []
    for each, place_x in zip(steps, across, strict=True):
        tile_row = graph.math("FLOOR", graph.fused(lower, 1.0 / columns, (each + 0.5) / columns))
        place = graph.join(place_x, graph.fused(tile_row, step, y), 0.0)
        values.append(graph.group(found, Place=place, EEVEE=given["EEVEE"]).outputs["Value"])
    below = graph.math("MAXIMUM", over, 1.0)  # below slice 0 T is that of slice 0
    if layout.power != 1.0:
        below = graph.math("POWER", below, layout.power)
    out = graph.add("NodeGroupOutput").inputs
    graph.put(out["Value"], values[0] if at_random else graph.mix(graph.difference(position, lower), *values))
    graph.put(out["Factor"], below)
    return tree


def gain(graph: Graph, layout: TableLayout, w: Socket) -> Socket | None:
    """|w|^power / |w|, None where that is 1; `TableLayout.scale` is left to the caller."""
    return None if layout.power == 1.0 else graph.math("POWER", w, layout.power - 1.0)


def albedo(name: str, found: bpy.types.NodeTree, nearest: bool = False) -> bpy.types.NodeTree:
    """Group that gives the directional albedo of the raw model with R = 1, of the surface as it is scaled.

    Inputs: cosine of the angle, components against t and b; left tile and part of the next one, shares of three depths
    (`scaled_place`), whether it is scaled at all; 1 where the image is the one that was written; 1 in EEVEE. The tiles
    lie in the image of directions; the first is that of the surface as baked.
    `nearest` takes one tile without a look at the next one: EEVEE compiles long enough without.
    """
    tree = new_group(f"Diffraction albedo {name}")
    sockets: dict[str, tuple[str, object]] = {each: (_FLOAT, None) for each in ("Cosine", "AgainstT", "AgainstB")}
    sockets |= {"Tile": (_FLOAT, 0.0), "TilePart": (_FLOAT, 0.0), "Shares": (_VECTOR, (1.0, 0.0, 0.0))}
    sockets |= {"IsScaled": (_FLOAT, 0.0), "Knows": (_FLOAT, 1.0)}
    interface(tree, sockets | {"EEVEE": (_FLOAT, 0.0)}, {"Albedo": _FLOAT})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    width, height, n_theta = float(importance.WIDTH), float(importance.HEIGHT), scaled_albedo.N_THETA
    n_phi = scaled_albedo.N_PHI
    theta = graph.math("ARCCOSINE", given["Cosine"])
    column = graph.fused(theta, (n_theta - 1) / (0.5 * math.pi * width), 0.5 / width)
    column = graph.sum(column, graph.product(given["Tile"], n_theta / width))
    row = graph.fused(
        graph.math("ARCTAN2", given["AgainstB"], given["AgainstT"]),
        n_phi / (2.0 * math.pi * height),
        (importance.VIEWS + 1.5 + 0.5 * n_phi) / height,
    )

    def tile(place: Socket) -> Socket:
        value = graph.group(found, Place=graph.join(place, row, 0.0), EEVEE=given["EEVEE"]).outputs["Value"]
        of_scaled = graph.scalar("DOT_PRODUCT", value, given["Shares"])
        return graph.choose(given["IsScaled"], graph.split(value)[0], of_scaled)

    if nearest:
        value = tile(graph.fused(graph.math("ROUND", given["TilePart"]), n_theta / width, column))
    else:
        value = graph.choose(given["TilePart"], tile(column), tile(graph.sum(column, n_theta / width)))
    # No albedo is better than a wrong one.
    graph.put(graph.add("NodeGroupOutput").inputs["Albedo"], graph.product(value, given["Knows"]))
    return tree


def scaled_place(graph: Graph, layout: TableLayout, scale: Socket, depth: Socket) -> tuple[Socket, Socket, Socket]:
    """Left tile, part of the next one, shares of three depths, see `precompute.table.scaled_albedo.place`."""
    most_s, most_q = layout.headroom
    at = graph.math("LOGARITHM", graph.product(scale, 1.0 / most_s), 2.0 ** (-1.0 / scaled_albedo.STEPS))
    at = graph.clamp(at, 0.0, scaled_albedo.N_SCALES - 1.0)
    lower = graph.math("MINIMUM", graph.math("FLOOR", at), scaled_albedo.N_SCALES - 2.0)
    a, b, c = scaled_albedo.DEPTHS
    q = graph.clamp(graph.product(depth, 1.0 / most_q), c, a)
    to = {each: graph.difference(q, each) for each in (a, b, c)}
    shares = graph.join(
        graph.product(to[b], to[c], 1.0 / ((a - b) * (a - c))),
        graph.product(to[a], to[c], 1.0 / ((b - a) * (b - c))),
        graph.product(to[a], to[b], 1.0 / ((c - a) * (c - b))),
    )
    return lower, graph.difference(at, lower), shares


def reflectance(name: str, layout: TableLayout, found: bpy.types.NodeTree) -> bpy.types.NodeTree:
    """Group (cosine of the view, 1 in EEVEE) -> XYZ that the table's stuff keeps from below."""
    tree = new_group(f"Diffraction reflectance {name}")
    interface(tree, {"Cosine": (_FLOAT, None), "EEVEE": (_FLOAT, 0.0)}, {"XYZ": _VECTOR})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    theta = graph.math("ARCCOSINE", graph.clamp(given["Cosine"], 0.0, 1.0))
    column = graph.fused(theta, (layout.n_reflectance - 1) / (0.5 * math.pi * layout.width), 0.5 / layout.width)
    place = graph.join(column, (layout.reflectance_y + 0.5) / layout.height, 0.0)
    value = graph.group(found, Place=place, EEVEE=given["EEVEE"]).outputs["Value"]
    graph.put(graph.add("NodeGroupOutput").inputs["XYZ"], value)
    return tree
