# SPDX-License-Identifier: GPL-3.0-or-later
"""A random direction into the environment as nodes, the same formulas as ``shaders/importance.osl``."""

from __future__ import annotations

import math
from typing import Any

import bpy

from ....precompute.table import importance
from ..node_graph import Graph, Socket, Value
from .surface import Parts, Surface

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"

#: Share of the second density for the raw model, which has 1 / cos_i in its weights, and the part of cos_r below which
#: it draws; as in ``shaders/diffraction.osl``.
FLAT_SHARE, FLAT_BELOW = 0.1, 0.3


#: What a random number is multiplied by, of which then the part behind the point is one more.
_LATER_DIGITS = 1000.0

#: Scale below which a direction into the environment is one of two; as in ``shaders/diffraction.osl``.
RESAMPLED_BELOW = 0.95


def random_numbers(graph: Graph) -> Socket:
    """A vector of three numbers in [0, 1): a hash of the place on the object, which differs from sample to sample."""
    place = graph.add("ShaderNodeTexCoord").outputs["Object"]
    noise = graph.add("ShaderNodeTexWhiteNoise", noise_dimensions="3D")
    graph.put(noise.inputs["Vector"], place)
    return noise.outputs["Color"]


def other_numbers(graph: Graph, random: Socket) -> Socket:
    """Random numbers of a second direction: half of the range away from the first's."""
    return graph.vector("FRACTION", graph.vector("ADD", random, (0.5, 0.5, 0.0)))


def one_of_two(graph: Graph, drawn: Any, again: Any, outside: tuple[Value, Value], xi: Socket) -> tuple[dict, Socket]:
    """Of two directions one, by what it sends, which stands for the mean of both: what a mirror needs, and a factor.

    Resampled importance sampling (Talbot et al. 2005), as in ``shaders/diffraction.osl``: what is stretched has other
    densities than those stored.

    Parameters
    ----------
    drawn, again
        Outputs of the group of `draw`.
    outside
        Of each, 1 where it is not left to a lamp.
    xi
        A random number.
    """
    sent = [
        graph.product(graph.scalar("DOT_PRODUCT", one["RGB"], (0.25, 0.5, 0.25)), one["Finished"])
        for one in (drawn, again)
    ]
    total = graph.sum(*sent)
    second = graph.math("LESS_THAN", graph.product(xi, total), sent[1])
    chosen = {name: graph.mix(second, drawn[name], again[name]) for name in ("RGB", "Half")}
    finished = [graph.product(one["Finished"], each) for one, each in zip((drawn, again), outside, strict=True)]
    factor = graph.choose(second, *finished)
    factor = graph.product(factor, graph.quotient(graph.product(total, 0.5), graph.choose(second, *sent)))
    return chosen, factor


def grey_of_plain(graph: Graph, drawn: Any) -> Socket:
    """Mean of the channels of f cos in a drawn direction, without albedos."""
    grey = graph.scalar("DOT_PRODUCT", drawn["RGB"], (1.0 / 3.0,) * 3)
    return graph.product(grey, graph.quotient(drawn["Weight"], drawn["Solid"]))


def left(graph: Graph, outside: Value, around: Value, of_lobe: Value, grey: Value) -> Socket:
    """The part of a drawn direction that a lamp's lobe leaves: beside the lamp, what f cos is more than in the lobe.

    A lobe answers all that shines within its cone by f cos towards the lamp. Of a mirror that is next to nothing about
    a lamp's image: what surrounds the lamp would be missing there, a dark rim.
    """
    more = graph.difference(1.0, graph.quotient(of_lobe, grey))
    return graph.math("MAXIMUM", outside, graph.product(around, more))


def draw(parts: Parts, image: bpy.types.Image) -> bpy.types.NodeTree:
    """Group (random numbers) -> direction, half vector of any length, colour and its factor, solid angle drawn.

    Directions are drawn in proportion to the luminance of f cos, see `precompute.table.importance`; colour times factor
    is f cos over the density. ``Finished`` is the factor with the albedos, ``Special`` is 1 where they count.
    """
    outputs = {"To": _VECTOR, "Half": _VECTOR, "RGB": _VECTOR, "Weight": _FLOAT}
    outputs |= {"Finished": _FLOAT, "Special": _FLOAT, "Solid": _FLOAT}
    surface, given, output = Surface.inside("Environment", parts, {"Random": _VECTOR}, outputs)
    for name, socket in zip(outputs, _draw(surface, image, given["Random"]), strict=True):
        surface.graph.put(output.inputs[name], socket)
    return surface.graph.tree


def _draw(surface: Surface, image: bpy.types.Image, random: Socket) -> tuple[Value, ...]:
    graph, cos_r = surface.graph, surface["CosR"]
    xi_1, xi_2, xi_3 = graph.split(random)
    own = [surface["WrX"], surface["WrY"]]
    stretch, wr, cos_d = _stretched_viewer(surface, own)
    row, slope = _view(graph, own, cos_d, _depth_set(surface, stretch, cos_d))

    def texel(column: Socket) -> tuple[Socket, Socket, Socket]:
        node = graph.add("ShaderNodeTexImage", image=image, interpolation="Closest", extension="EXTEND")
        graph.put(node.inputs["Vector"], graph.join(column, row, 0.0))
        return graph.split(node.outputs["Color"])

    width, n_r, n_phi = float(importance.WIDTH), float(importance.N_R), float(importance.N_PHI)
    place_r, place_phi = graph.product(xi_1, 0.9999999 * n_r), graph.product(xi_2, 0.9999999 * n_phi)
    k, column = graph.math("FLOOR", place_r), graph.math("FLOOR", place_phi)
    e_0, e_1, ring = texel(graph.fused(k, 1.0 / width, 0.5 / width))
    start = graph.fused(column, 1.0 / width, (n_r + 0.5) / width)
    t_0, t_1, t_m = texel(graph.fused(ring, n_phi / width, start))
    de, dt = graph.difference(e_1, e_0), graph.difference(t_1, t_0)
    s = graph.math("SQRT", graph.fused(graph.difference(place_r, k), de, e_0))
    part = graph.difference(place_phi, column)
    c = graph.quotient(graph.difference(t_1, t_m), graph.difference(t_m, t_0))
    bend = graph.fused(graph.difference(1.0, part), c, part)
    # From the negative u axis, as `lookup.transform` counts: (-u, -v) = r (cos, sin).
    turn = graph.fused(graph.fused(dt, graph.quotient(part, bend), t_0), 2.0 * math.pi, -math.pi)
    cos_phi, sin_phi = graph.math("COSINE", turn), graph.math("SINE", turn)
    area = graph.quotient(graph.product(de, dt, c), graph.product(bend, bend))

    b = graph.fused(wr[0], cos_phi, graph.product(wr[1], sin_phi))  # the negative of the one in importance.osl
    cos2 = graph.product(cos_d, cos_d)
    root = graph.math("SQRT", graph.fused(b, b, cos2))
    reach, far = graph.sum(root, b), graph.difference(root, b)
    a = graph.math("MINIMUM", slope, reach)
    t, a3 = graph.difference(1.0, s), graph.product(a, 3.0)
    as3 = graph.product(a3, s)
    rs = graph.product(reach, s)
    per_s = graph.fused(graph.product(a3, t), t, graph.product(rs, graph.fused(s, -2.0, 3.0)))
    r = graph.product(s, per_s)
    left = graph.difference(graph.fused(rs, 2.0, reach), as3)
    rest = graph.math("SQRT", graph.product(left, graph.sum(r, far)))
    per_area = graph.product(per_s, graph.fused(rs, 2.0, graph.difference(a, as3)))
    constant = 1.5 * importance.N_R * 2.0 * math.pi * importance.N_PHI
    weight = graph.quotient(graph.product(area, per_area, constant), rest)
    cos_i = graph.product(t, rest)

    cos_i, r, weight = _stretched(surface, stretch, own, (cos_phi, sin_phi), cos_i, r, weight)
    x, y = graph.product(r, cos_phi), graph.product(r, sin_phi)
    if not surface.parts.conserve:
        flat = _flat(graph, cos_r, xi_1, xi_2, own)
        return _either(surface, flat, (x, y, cos_i), weight, xi_3)
    return _drawn(surface, x, y, cos_i, (r, graph.product(r, r)), turn, weight, xi_3)


def _stretched_viewer(surface: Surface, wr: list[Socket]) -> tuple[Socket, list[Socket], Socket]:
    """s as far as it is below 1, and the viewer for whom directions on a surface stretched by it are drawn.

    As in ``shaders/importance.osl``: its ``wr_xy`` is s times as long.
    """
    graph, cos_r = surface.graph, surface["CosR"]
    stretch = graph.math("MINIMUM", surface["Scale"], 1.0)
    sine2 = graph.product(graph.difference(1.0, graph.product(cos_r, cos_r)), graph.product(stretch, stretch))
    cos_d = graph.math("SQRT", graph.math("MAXIMUM", graph.difference(1.0, sine2), 0.0))
    cos_d = graph.choose(_is_stretched(graph, stretch), cos_r, cos_d)
    return stretch, [graph.product(each, stretch) for each in wr], cos_d


def _is_stretched(graph: Graph, stretch: Socket) -> Socket:
    return graph.math("LESS_THAN", stretch, 1.0)


def _stretched(
    surface: Surface, stretch: Socket, wr: list[Socket], turn: tuple[Socket, Socket], cos_i: Socket, r: Socket,
    weight: Socket,
) -> tuple[Socket, Socket, Socket]:  # fmt: skip
    """cos_i, r and weight of the direction on the stretched surface; the weight is 0 beyond the horizon."""
    graph, flag = surface.graph, _is_stretched(surface.graph, stretch)
    r = graph.quotient(r, stretch)
    x, y = (graph.difference(graph.product(r, t), each) for t, each in zip(turn, wr, strict=True))
    rest = graph.difference(1.0, graph.fused(x, x, graph.product(y, y)))
    z = graph.math("SQRT", graph.math("MAXIMUM", rest, 1e-12))
    share = graph.quotient(cos_i, graph.product(graph.product(stretch, stretch), z))
    share = graph.product(share, graph.math("GREATER_THAN", rest, 0.0))
    return graph.choose(flag, cos_i, z), r, graph.product(weight, graph.choose(flag, 1.0, share))


def _depth_set(surface: Surface, stretch: Socket, cos_d: Socket) -> Socket:
    """Number of the set of views for the depth of the surface, see `importance.depth_set`."""
    graph, cosine = surface.graph, importance.SET_COSINE
    light = graph.fused(graph.product(stretch, stretch), cosine * cosine - 1.0, 1.0)
    seen = graph.sum(cos_d, graph.math("SQRT", graph.math("MAXIMUM", light, 0.0)))
    judged = graph.quotient(graph.product(surface["Depth"], graph.sum(surface["CosR"], cosine)), seen)
    step = 1.0 / (importance.DEPTHS[0] - importance.DEPTHS[1])
    chosen = graph.clamp(graph.math("FLOOR", graph.fused(judged, -step, step + 0.5)), 0.0, len(importance.DEPTHS) - 1.0)
    # The first set where nothing is painted: Cycles then drops all of this.
    return graph.product(surface["IsScaled"], chosen)


def _view(graph: Graph, wr: list[Socket], cos_r: Socket, chosen: Socket) -> tuple[Socket, Socket]:
    """Row of the image as a part of its height, and a third of dr / ds at the specular peak.

    Any view would do: a colour ramp over sin_r^2, which has 256 steps, knows the polar angle well enough, and what
    hangs on it.
    """
    sine2 = graph.difference(1.0, graph.product(cos_r, cos_r))
    first, others = (_of_polar_angle(graph, sine2, number) for number in (0, 1))
    is_other = graph.math("MINIMUM", chosen, 1.0)
    start, per_radian, middle = graph.split(graph.mix(is_other, first.outputs["Color"], others.outputs["Color"]))
    # Counted as the viewer's albedo counts: where that is looked up Cycles takes one arc tangent for both.
    against = graph.math("ARCTAN2", *(graph.product(each, -1.0) for each in reversed(wr)))
    count = graph.product(per_radian, 2.0 * math.pi)
    j = graph.math("FLOOR", graph.math("FLOORED_MODULO", graph.fused(against, per_radian, middle), count))
    row = graph.fused(j, 1.0 / importance.HEIGHT, start)
    further = graph.math("MAXIMUM", graph.difference(chosen, 1.0), 0.0)
    row = graph.sum(row, graph.product(further, importance.SET_VIEWS / importance.HEIGHT))
    return row, first.outputs["Alpha"]


def _of_polar_angle(graph: Graph, sine2: Socket, chosen: int) -> bpy.types.Node:
    """Colour ramp: the middle of a polar angle's first row as a part of the image's height, its views per radian, half
    of them and a half; and a third of dr / ds (`importance._peak_slope`)."""
    node: Any = graph.add("ShaderNodeValToRGB")
    graph.put(node.inputs[0], sine2)
    ramp = node.color_ramp
    ramp.interpolation = "CONSTANT"
    step = importance.VIEW_END / importance.N_VIEWS
    for i in range(importance.N_VIEWS):
        # Cycles rounds places down to a 255th.
        place = max(math.tanh((i - 0.5) * step) ** 2 - 0.5 / 255.0, 0.0) if i else 0.0
        if i < 2:
            element = ramp.elements[i]
            element.position = place
        else:
            element = ramp.elements.new(place)
        count = importance.azimuths(i, chosen)
        start = (importance.first_view(i, chosen) + 0.5) / importance.HEIGHT
        slope = min(1.0 - math.tanh((i + 0.5) * step), 2.0 / 3.0)
        element.color = (start, count / (2.0 * math.pi), 0.5 * count + 0.5, slope)
    return node


def _drawn(
    surface: Surface, x: Socket, y: Socket, cos_i: Socket, radius: tuple[Socket, Socket], turn: Socket, weight: Socket,
    xi_3: Socket,
) -> tuple[Value, ...]:  # fmt: skip
    """All outputs from the components of h = wi + wr along t and b, cos(theta_i) and the weight without f cos.

    `radius` is the length of (x, y) and its square.
    """
    graph = surface.graph
    w = graph.sum(cos_i, surface["CosR"])
    h = graph.vector("MULTIPLY_ADD", surface["T"], x, graph.scaled(surface["N"], w))
    h = graph.vector("MULTIPLY_ADD", surface["B"], y, h)
    to = graph.vector("SUBTRACT", h, surface["Viewer"])
    solid = weight
    w, weight = surface.behind_face(w, cos_i, graph.product(weight, surface["Gain"]))
    # Others take the third number as it is: its later digits are as random, and their own.
    rgb, factor = surface.value(radius, turn, w, h, Xi=graph.math("FRACT", graph.product(xi_3, _LATER_DIGITS)))
    weight = graph.product(weight, factor)
    return to, h, rgb, weight, *surface.with_albedo(weight, x, y, cos_i), solid


def _flat(graph: Graph, cos_r: Socket, xi_1: Socket, xi_2: Socket, wr: list[Socket]) -> tuple[Socket, Socket, Socket]:
    """x and y of h and cos_i of a direction near the horizon, even in solid angle, for the raw model."""
    z = graph.product(xi_1, cos_r, FLAT_BELOW)
    s = graph.math("SQRT", graph.difference(1.0, graph.product(z, z)))
    phi = graph.product(xi_2, 2.0 * math.pi)
    x, y = (graph.fused(s, graph.math(name, phi), each) for name, each in zip(("COSINE", "SINE"), wr, strict=True))
    return x, y, z


def _either(surface: Surface, flat: tuple, local: tuple, weight: Socket, xi_3: Socket) -> tuple[Value, ...]:
    """The drawn direction, or one in ten near the horizon, where the first density then draws none."""
    graph, cos_r = surface.graph, surface["CosR"]
    is_flat = graph.math("LESS_THAN", xi_3, FLAT_SHARE)
    x, y, cos_i = (graph.fused(is_flat, graph.difference(f, m), m) for f, m in zip(flat, local, strict=True))
    limit = graph.product(cos_r, FLAT_BELOW)
    steep = graph.math("GREATER_THAN", local[2], limit)
    steep_weight = graph.product(weight, steep, 1.0 / (1.0 - FLAT_SHARE))
    flat_weight = graph.product(limit, 2.0 * math.pi / FLAT_SHARE)
    chosen = graph.fused(is_flat, graph.difference(flat_weight, steep_weight), steep_weight)
    square = graph.fused(x, x, graph.product(y, y))
    radius = graph.math("SQRT", square), square
    return _drawn(surface, x, y, cos_i, radius, graph.math("ARCTAN2", y, x), chosen, xi_3)
