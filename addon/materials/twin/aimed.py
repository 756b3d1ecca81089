# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a lamp's lobe is aimed, how wide it is and what it counts, as ``shaders/lamps.osl`` and ``diffraction.osl``.

A *whole* lobe holds all of a lamp and no other one; f is taken at a random point of the lamp. A *narrow* lobe stands
about a random place of a lamp beside others, or of one that shines unevenly (spread, texture, a glowing mesh).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import bpy

from ..node import lamp_nodes
from ..node_graph import Graph, Socket, Value, interface, new_group
from .seen import ALL_ROUND, Seen, seen

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"

#: Radius (radians) up to which a sun takes its random point by the cheap way, see `_near`.
SMALL_SUN = 0.03

#: As in ``shaders/diffraction.osl``: least radius of a whole lobe among others, limits of narrow ones.
CONE_MIN, NARROW_MIN, NARROW_MAX = 0.03, 0.005, 0.012

#: As in ``shaders/lamps.osl``: of lobes about a part of a thin lamp, in parts of its radius; the least radius.
SLENDER_PART, SLENDER_MOST, SLENDER_LEAST = 0.2, 0.6, 0.1

#: Steps of a lattice that fills the cube evenly (Roberts 2018, R3), as in ``shaders/diffraction.osl``.
_LATTICE = (0.8191725134, 0.6710436067, 0.5497004779)

#: Inputs of the group beside a lamp's, and outputs.
_INPUTS = {
    "Position": _VECTOR, "Cone": _FLOAT, "Random": _VECTOR, "Step": _VECTOR, "Gap": _FLOAT,
    "Drawn": _VECTOR, "Drawn Again": _VECTOR, "Sky": _FLOAT,
}  # fmt: skip
#: Outputs for a lobe about a part of a thin lamp, see `_slender`.
SLENDER = {"Slender": _FLOAT, "SlenderAim": _VECTOR, "SlenderWidth": _FLOAT, "SlenderWeight": _FLOAT}
OUTPUTS = {
    "To": _VECTOR, "Aim": _VECTOR, "Width": _FLOAT, "Weight": _FLOAT, "Gain": _FLOAT, "Cosine": _FLOAT,
    "Narrow": _FLOAT,
    "On": _FLOAT, "Outside": _FLOAT, "Outside Again": _FLOAT, "Around": _FLOAT, "Around Again": _FLOAT,
} | SLENDER  # fmt: skip


def step(slot: int) -> tuple[float, float, float]:
    """What a slot's random numbers are away from those that all share."""
    x, y, z = (math.fmod(slot * each, 1.0) for each in _LATTICE)
    return x, y, z


def aimed() -> bpy.types.NodeTree:
    """Group of a slot.

    Direction to a random point, direction and half-angle of the lobe, what f cos is to be multiplied by, which part of
    it evens out the solid angle of points, cosine of a whole lobe (2 where there is none), whether it is a narrow one,
    whether there is a lamp, and 1 where the direction ``Drawn`` from the environment is not left to it, or where it
    lies in a whole lobe's cone beside the lamp; the same of another one, ``Drawn Again``. What `_slender` gives counts
    where ``Sky`` is 1, that is, where there are mirrors into the environment.
    """
    tree = new_group("Diffraction lobe of a lamp")
    interface(tree, {name: (kind, None) for name, kind in (lamp_nodes.OUTPUTS | _INPUTS).items()}, OUTPUTS)
    graph = Graph(tree)
    given: Any = graph.add("NodeGroupInput").outputs
    lamp = seen(graph, given["Position"], given)

    # Spread and unevenness are constants to Cycles; only what stands beside others is known at the place alone.
    has_spread = graph.product(lamp.is_area, graph.math("LESS_THAN", given["Size"], ALL_ROUND))
    is_uneven = graph.math("MINIMUM", graph.sum(given["Uneven"], has_spread), 1.0)
    is_crowded = graph.math("LESS_THAN", given["Gap"], lamp.held)
    is_wide = graph.math("GREATER_THAN", lamp.radius, CONE_MIN)
    is_narrow = graph.product(is_wide, graph.choose(is_uneven, is_crowded, 1.0))
    is_whole = graph.difference(1.0, is_narrow)
    width = _narrow_width(graph, given, lamp)
    room = graph.math("MAXIMUM", given["Gap"], CONE_MIN)
    cone = graph.math("MAXIMUM", graph.math("MINIMUM", given["Cone"], room), lamp.held)
    cone = graph.math("MINIMUM", cone, 0.5 * math.pi)

    # Where light within a cone is uneven, lobes about its rim count too; else they keep clear of the lamp's edge.
    beyond = graph.product(given["Uneven"], graph.difference(1.0, lamp.is_area))
    shown_width = graph.product(width, is_narrow)
    radius = graph.sum(lamp.radius, graph.product(beyond, shown_width))
    inset = graph.product(graph.difference(1.0, beyond), is_narrow, NARROW_MIN)
    far = _far(graph, given, lamp, radius, inset, graph.product(width, has_spread), has_spread)
    to, gain, omega, low, high, clear = far
    # Near the edge a lobe as wide would see more than the lamp.
    width = graph.math("MINIMUM", width, graph.choose(beyond, graph.product(clear, NARROW_MIN), NARROW_MAX))
    is_far = graph.math("GREATER_THAN", graph.product(given["Size"], lamp.is_sun), 2.0 * SMALL_SUN)
    is_far = graph.math("MAXIMUM", is_far, graph.difference(1.0, lamp.is_sun))
    near = graph.scaled(_near(graph, given, lamp), graph.difference(1.0, is_far))
    to = graph.vector("ADD", near, graph.scaled(to, is_far))
    s = graph.math("SINE", graph.product(cone, 0.5))
    gain = graph.choose(is_far, 1.0, gain)
    of_whole = graph.product(s, s, gain, 4.0 * math.pi)

    # Of what is not told by the list alone EEVEE shall make nothing.
    aim = graph.mix(is_narrow, lamp.axis, _not_in_eevee(graph, to))
    whole_cosine = graph.math("COSINE", cone)
    has_whole = graph.product(is_whole, lamp.is_on)

    held_cosine = graph.math("COSINE", lamp.held)

    def outside(drawn: Socket) -> tuple[Socket, Socket]:
        cosine = graph.scalar("DOT_PRODUCT", drawn, lamp.axis)
        beside_whole = graph.choose(has_whole, 1.0, graph.math("LESS_THAN", cosine, whole_cosine))
        within_narrow = graph.math("GREATER_THAN", cosine, graph.math("COSINE", radius))
        within_area = holds(graph, drawn, lamp, low, high)
        within = graph.product(is_narrow, lamp.is_on, graph.choose(lamp.is_area, within_narrow, within_area))
        off_ball, off_area = graph.math("LESS_THAN", cosine, held_cosine), graph.difference(1.0, within_area)
        around = graph.product(has_whole, graph.choose(lamp.is_area, off_ball, off_area))
        return graph.difference(beside_whole, within), around

    slender = _slender(graph, lamp, to, omega)
    slender["Slender"] = graph.product(slender["Slender"], has_whole, given["Sky"])
    outside_drawn, outside_again = outside(given["Drawn"]), outside(given["Drawn Again"])
    outputs: dict[str, Value] = {
        "To": to, "Aim": aim, "Width": graph.choose(is_narrow, cone, width),
        "Weight": graph.choose(is_narrow, of_whole, omega), "Cosine": graph.choose(has_whole, 2.0, whole_cosine),
        "Gain": gain, "Narrow": is_narrow, "On": lamp.is_on,
        "Outside": outside_drawn[0], "Outside Again": outside_again[0],
        "Around": outside_drawn[1], "Around Again": outside_again[1],
    } | slender  # fmt: skip
    out = graph.add("NodeGroupOutput")
    for name, socket in outputs.items():
        graph.put(out.inputs[name], socket)
    return tree


def _slender(graph: Graph, lamp: Seen, to: Socket, omega: Socket) -> dict[str, Value]:
    """Whether a lamp is thin, and the lobe about a part of it: ``lamp_slender`` of ``shaders/lamps.osl``.

    A cone that holds a thin lamp holds far more of what surrounds it. Such a lobe stands about the middle of the lamp,
    next to the random direction `to`, clear of the ends; its weight is the lamp's solid angle over the part of the lobe
    that the lamp fills, a band through its middle.
    """
    length2 = [graph.scalar("DOT_PRODUCT", each, each) for each in (lamp.u, lamp.v)]
    is_v = graph.math("LESS_THAN", *length2)  # constants to Cycles, as all that follows for other lamps
    is_u = graph.difference(1.0, is_v)
    along = graph.vector("ADD", graph.scaled(lamp.u, is_u), graph.scaled(lamp.v, is_v))
    across = graph.vector("ADD", graph.scaled(lamp.u, is_v), graph.scaled(lamp.v, is_u))
    thick = graph.math("SQRT", graph.math("MINIMUM", *length2))
    twice = graph.quotient(graph.product(thick, 2.0), lamp.distance)
    width = graph.math("MAXIMUM", twice, graph.product(lamp.radius, SLENDER_PART))
    is_thin = graph.math("LESS_THAN", width, graph.product(lamp.radius, SLENDER_MOST))
    is_thin = graph.product(lamp.is_area, is_thin, graph.math("GREATER_THAN", lamp.radius, SLENDER_LEAST))

    normal = graph.vector("CROSS_PRODUCT", lamp.u, lamp.v)
    away = graph.quotient(graph.scalar("DOT_PRODUCT", lamp.offset, normal), graph.scalar("DOT_PRODUCT", to, normal))
    point = graph.scaled(to, away)
    edge = graph.vector("CROSS_PRODUCT", point, along)
    reach, square = graph.scalar("LENGTH", edge), graph.scalar("DOT_PRODUCT", point, point)
    at = graph.scalar("DOT_PRODUCT", graph.vector("SUBTRACT", point, lamp.offset), along)
    at = graph.quotient(at, graph.math("MAXIMUM", *length2))
    room = graph.difference(1.0, graph.quotient(graph.product(width, square), reach))
    room = graph.math("MAXIMUM", room, 0.0)
    at = graph.clamp(at, graph.product(room, -1.0), room)
    aim = graph.vector("MULTIPLY_ADD", along, graph.for_cycles(graph.product(at, 0.01)), lamp.offset)

    half = graph.math("ABSOLUTE", graph.scalar("DOT_PRODUCT", across, edge))
    half = graph.quotient(half, graph.product(reach, graph.math("SQRT", square)))
    of_ellipse = graph.math("SQRT", graph.difference(1.0, graph.product(at, at)))
    half = graph.product(half, graph.choose(lamp.is_rectangle, of_ellipse, 1.0))
    half = graph.clamp(graph.quotient(half, width), 1e-4, 1.0)
    rest = graph.math("SQRT", graph.difference(1.0, graph.product(half, half)))
    filled = graph.product(graph.fused(half, rest, graph.math("ARCSINE", half)), 2.0 / math.pi)
    return {
        "Slender": is_thin, "SlenderAim": graph.vector("NORMALIZE", aim), "SlenderWidth": width,
        "SlenderWeight": graph.quotient(omega, filled),
    }  # fmt: skip


def _not_in_eevee(graph: Graph, vector: Socket) -> Socket:
    """A vector in Cycles, 0 in EEVEE, see `Graph.for_cycles`."""
    parts = graph.split(graph.scaled(vector, 0.01))
    return graph.join(*(graph.for_cycles(each) for each in parts))


def _narrow_width(graph: Graph, given: Any, lamp: Seen) -> Socket:
    """Half-angle of a narrow lobe: by the lamp's radius, of a thin one by its width, and less than light of a spread
    changes within."""
    half = graph.product(graph.math("MINIMUM", given["Size"], 3.1), 0.5)
    side = graph.math("MINIMUM", *(graph.scalar("LENGTH", each) for each in (lamp.u, lamp.v)))
    of_area = graph.math(
        "MINIMUM",
        graph.product(graph.math("TANGENT", half), 0.035),
        graph.quotient(graph.product(side, 0.1), lamp.distance),
    )
    by_spread = graph.choose(lamp.is_area, NARROW_MAX, of_area)
    width = graph.math("MINIMUM", graph.product(lamp.radius, 0.3), graph.math("MINIMUM", by_spread, NARROW_MAX))
    return graph.math("MAXIMUM", width, NARROW_MIN)


def _near(graph: Graph, given: Any, lamp: Seen) -> Socket:
    """A random direction to a small sun: of the same mean square, the same random numbers for all.

    That of a cube which has, from any side, the mean square of the disc. Cycles folds all but the sum.
    """
    side = graph.product(lamp.radius, math.sqrt(3.0))
    corner = graph.vector("SUBTRACT", lamp.axis, graph.product(side, 0.5))
    to = graph.vector("MULTIPLY_ADD", given["Random"], side, corner)
    return graph.vector("NORMALIZE", to)


def _far(
    graph: Graph, given: Any, lamp: Seen, radius: Socket, inset: Socket, margin: Socket, has_spread: Socket
) -> tuple[Socket, Socket, Socket, list[Socket], list[Socket], Socket]:
    """A random direction to a wide lamp.

    Suns and balls stand for the disc that they look like. Points are drawn evenly from the part of the lamp that shines
    here; solid angle per area goes as the cube of one over the distance.

    Returns
    -------
    to
        Unit.
    gain
        The solid angle per area in units of its mean over the lamp, taken at four points, see `_inner_point`.
    omega
        Solid angle per probability: that of the part of the lamp that shines, evenly drawn.
    low, high
        The part that shines, along u and along v, in units of them.
    clear
        How far the place is from the lamp's edge, in units of `inset`.
    """
    x, y, _ = graph.split(graph.vector("FRACTION", graph.vector("ADD", given["Random"], given["Step"])))
    upright = graph.math("GREATER_THAN", graph.math("ABSOLUTE", graph.split(lamp.axis)[2]), 0.7)
    helper = graph.mix(upright, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    side = graph.vector("NORMALIZE", graph.vector("CROSS_PRODUCT", helper, lamp.axis))
    other = graph.vector("CROSS_PRODUCT", lamp.axis, side)
    tan = graph.math("TANGENT", graph.math("MINIMUM", radius, 1.5))
    tan = graph.product(tan, graph.difference(1.0, lamp.is_area))
    u, v = (graph.vector("ADD", graph.scaled(each, tan), h) for each, h in ((side, lamp.u), (other, lamp.v)))
    middle = graph.mix(lamp.is_area, lamp.axis, lamp.offset)
    normal = graph.vector("CROSS_PRODUCT", u, v)
    area = graph.scalar("LENGTH", normal)
    # The distance of the lamp's plane times |u x v|.
    height = graph.math("ABSOLUTE", graph.scalar("DOT_PRODUCT", normal, middle))

    # What its spread leaves is a square about the foot, wider by the lobe. All of this folds without spread.
    half = graph.math("TANGENT", graph.math("MINIMUM", graph.fused(given["Size"], 0.5, margin), 1.57))
    reach = graph.quotient(graph.product(height, half), area)
    low, high, size, lengths, even = [], [], [], [], []
    for axis, random in ((u, x), (v, y)):
        length2 = graph.scalar("DOT_PRODUCT", axis, axis)
        length = graph.math("SQRT", length2)
        foot = graph.quotient(graph.product(graph.scalar("DOT_PRODUCT", middle, axis), -1.0), length2)
        about = graph.quotient(reach, length)
        low.append(graph.choose(has_spread, -1.0, graph.math("MAXIMUM", graph.difference(foot, about), -1.0)))
        high.append(graph.choose(has_spread, 1.0, graph.math("MINIMUM", graph.sum(foot, about), 1.0)))
        size.append(graph.math("MAXIMUM", graph.difference(high[-1], low[-1]), 0.0))
        lengths.append(length)
        even.append(graph.fused(graph.difference(high[-1], low[-1]), random, low[-1]))
    # On a disc, evenly; with spread what is drawn outside of it counts nothing.
    is_round = graph.difference(1.0, lamp.is_rectangle)
    is_disc = graph.product(is_round, graph.difference(1.0, has_spread))
    root, turn = graph.math("SQRT", x), graph.product(y, 2.0 * math.pi)
    disc = [graph.product(root, graph.math(name, turn)) for name in ("COSINE", "SINE")]
    at = [graph.choose(is_disc, e, d) for e, d in zip(even, disc, strict=True)]
    beyond = graph.math("GREATER_THAN", graph.fused(at[0], at[0], graph.product(at[1], at[1])), 1.0)
    counts = graph.difference(1.0, graph.product(is_round, has_spread, beyond))
    to = graph.vector("MULTIPLY_ADD", v, at[1], graph.vector("MULTIPLY_ADD", u, at[0], middle))
    square = graph.scalar("DOT_PRODUCT", to, to)

    # Places near the edge move to where a lobe, as seen from here, meets nothing else, and all a little outwards, which
    # keeps sums of cubics exact; of lamps thinner than it the lobes miss a part.
    edge = graph.product(inset, graph.quotient(graph.product(square, area), graph.math("MAXIMUM", height, 1e-12)))
    edges = [graph.quotient(edge, length) for length in lengths]
    rooms = [graph.math("MAXIMUM", graph.difference(1.0, each), 1e-6) for each in edges]
    stretched = [_stretched(graph, place, room, is_round, has_spread) for place, room in zip(at, rooms, strict=True)]
    far_out = [graph.quotient(place, room) for place, room in zip(stretched, rooms, strict=True)]
    outwards = graph.math("SQRT", graph.fused(far_out[0], far_out[0], graph.product(far_out[1], far_out[1])))
    outwards = graph.math("MAXIMUM", outwards, 1.0)
    kept, covered = [], []
    for place, room, each in zip(stretched, rooms, edges, strict=True):
        within = graph.math("MAXIMUM", graph.math("MINIMUM", place, room), graph.product(room, -1.0))
        kept.append(graph.choose(is_round, within, graph.quotient(place, outwards)))
        thin = graph.quotient(1.0, graph.math("MAXIMUM", graph.product(each, lamp.is_area), 1.0))
        covered.append(graph.product(thin, graph.fused(graph.product(thin, thin), 1.0 - 4.0 / math.pi, 4.0 / math.pi)))
    to = graph.vector("MULTIPLY_ADD", v, kept[1], graph.vector("MULTIPLY_ADD", u, kept[0], middle))
    nearness = graph.math("POWER", graph.scalar("DOT_PRODUCT", to, to), -1.5)
    away = [graph.difference(1.0, graph.math("ABSOLUTE", place)) for place in kept]
    of_strip = graph.math("MINIMUM", *(graph.quotient(way, each) for way, each in zip(away, edges, strict=True)))
    of_disc = graph.math("SQRT", graph.fused(kept[0], kept[0], graph.product(kept[1], kept[1])))
    of_disc = graph.quotient(graph.difference(1.0, of_disc), graph.math("MAXIMUM", *edges))
    clear = graph.math("MAXIMUM", graph.choose(is_round, of_strip, of_disc), 1.0)

    inner = [graph.scaled(each, _inner_point(graph, each, other, lamp)) for each, other in ((u, v), (v, u))]
    total: Any = None
    for sign in ("ADD", "SUBTRACT"):
        corner = graph.vector(sign, *inner)
        for way in ("ADD", "SUBTRACT"):
            one = graph.math("POWER", graph.scalar("LENGTH", graph.vector(way, middle, corner)), -3.0)
            total = one if total is None else graph.sum(total, one)
    gain = graph.quotient(graph.product(nearness, 4.0), total)
    shape = graph.choose(is_disc, 1.0, 0.25 * math.pi)
    omega = graph.product(shape, size[0], size[1], height)
    omega = graph.product(omega, nearness, counts)
    omega = graph.quotient(omega, graph.product(*covered))
    return graph.vector("NORMALIZE", to), gain, omega, low, high, clear


def _inner_point(graph: Graph, axis: Socket, other: Socket, lamp: Seen) -> Socket:
    """Where along a half axis the mean of one over the distance cubed is taken, as a part of it.

    Over a thin lamp seen from the front, of the half length t in units of the distance, the mean of
    (1 + (t x)^2)^-1.5 is (1 + t^2)^-0.5, its value at x^2 = ((1 + t^2)^(1/3) - 1) / t^2. A rectangle that is wide both
    ways counts as farther away: with a quarter of its other half axis squared the mean is within 0.2 % up to half axes
    of the distance, where the points of a small lamp give 11 % less. Of a disc 2 (1 - (1 + t^2)^-0.5) / t^2 is the
    value at x = y with x^2 = ((1 + t^2)^a - 1) / (4 a t^2) and a = 0.58, to the fourth order of t. For small lamps
    these are 1 / 3 and 1 / 4, which integrate cubics exactly.
    """
    beside = graph.product(lamp.is_rectangle, graph.scalar("DOT_PRODUCT", other, other))
    away = graph.fused(lamp.distance, lamp.distance, graph.product(beside, 0.25))
    square = graph.quotient(graph.scalar("DOT_PRODUCT", axis, axis), away)
    power = graph.fused(lamp.is_rectangle, 1.0 / 3.0 - 0.58, 0.58)
    of_small = graph.fused(lamp.is_rectangle, 1.0 - 0.25 / 0.58, 0.25 / 0.58)
    grown = graph.difference(graph.math("POWER", graph.sum(square, 1.0), power), 1.0)
    return graph.math("SQRT", graph.product(of_small, graph.quotient(grown, square)))


def _stretched(graph: Graph, place: Socket, room: Socket, is_round: Socket, has_spread: Socket) -> Socket:
    """``lamp_stretch`` of ``shaders/lamps.osl``, times a place; what a spread leaves stays as it is."""
    r2 = graph.product(room, room)
    of_strip = graph.quotient(graph.product(r2, room, 2.0), graph.math("MAXIMUM", graph.fused(r2, 3.0, -1.0), 0.05))
    of_disc = graph.quotient(r2, graph.math("SQRT", graph.math("MAXIMUM", graph.fused(r2, 2.0, -1.0), 0.05)))
    by = graph.math("MAXIMUM", graph.choose(is_round, of_strip, of_disc), 1.0)
    return graph.product(place, graph.choose(has_spread, by, 1.0))


def holds(
    graph: Graph, direction: Socket, lamp: Seen, low: Sequence[Value], high: Sequence[Value]
) -> Socket:  # fmt: skip
    """1 where a direction meets the part of an area lamp that shines here."""
    normal = graph.vector("CROSS_PRODUCT", lamp.u, lamp.v)
    along = graph.scalar("DOT_PRODUCT", direction, normal)
    t = graph.quotient(graph.scalar("DOT_PRODUCT", lamp.offset, normal), along)
    q = graph.vector("SUBTRACT", graph.scaled(direction, t), lamp.offset)
    inside: Any = graph.math("GREATER_THAN", t, 0.0)
    square: Any = None
    for axis, first, last in zip((lamp.u, lamp.v), low, high, strict=True):
        each = graph.quotient(graph.scalar("DOT_PRODUCT", q, axis), graph.scalar("DOT_PRODUCT", axis, axis))
        inside = graph.product(inside, graph.math("GREATER_THAN", each, first), graph.math("LESS_THAN", each, last))
        square = graph.product(each, each) if square is None else graph.fused(each, each, square)
    beyond = graph.product(graph.difference(lamp.is_area, lamp.is_rectangle), graph.math("GREATER_THAN", square, 1.0))
    return graph.product(inside, graph.difference(1.0, beyond))
