# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps of the scene's list as groups: lobes that Cycles aims at them, colours that EEVEE shows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import bpy

from ...lights import slots
from ..node import lamp_nodes
from ..node_graph import Graph, Socket, Value
from .surface import Parts, Surface

_FLOAT, _VECTOR, _SHADER = "NodeSocketFloat", "NodeSocketVector", "NodeSocketShader"

#: Radius (radians) up to which a sun takes its random point by the cheap way, see `_near`.
NARROW = 0.03

#: Slots that EEVEE reads: there each costs whether a lamp is in it or not.
EEVEE_LAMPS_MAX = 4

#: Alpha (roughness squared) of EEVEE's lobe, for small lamps and at most: it is four times as wide as the lamp.
#: Narrower ones its tables of GGX do not hold, wider ones see more of the other lamps and of the world.
EEVEE_ALPHA, EEVEE_ALPHA_MAX = 0.04, 0.25

#: What EEVEE's tables make of the lobe's peak, measured: 0.995 to 0.997 at all angles for the smallest alpha.
EEVEE_PEAK = 0.9957

#: Steps of a lattice that fills the cube evenly (Roberts 2018, R3), as in ``shaders/diffraction.osl``.
_LATTICE = (0.8191725134, 0.6710436067, 0.5497004779)


@dataclass(frozen=True)
class Seen:
    """A lamp as a point of the surface sees it.

    Parameters
    ----------
    axis
        Direction to its middle, unit.
    radius
        Of a cone about the axis that holds it, radians.
    cone
        Half-angle of its lobe.
    offset
        To its middle; of a sun the direction as the list has it.
    u, v
        Half extents of an area lamp, else 0.
    is_on, is_sun, is_area, is_rectangle
        Numbers 0 or 1.
    """

    axis: Socket
    radius: Socket
    cone: Socket
    offset: Socket
    u: Socket
    v: Socket
    is_on: Socket
    is_sun: Socket
    is_area: Socket
    is_rectangle: Socket


def jitter(graph: Graph, random: Socket) -> Socket:
    """A random vector in a cube that has, from any side, the mean square of a disc of radius 1."""
    return graph.vector("MULTIPLY_ADD", random, (math.sqrt(3.0),) * 3, (-0.5 * math.sqrt(3.0),) * 3)


def step(slot: int) -> tuple[float, float, float]:
    """What a slot's random numbers are away from those that all share."""
    x, y, z = (math.fmod(slot * each, 1.0) for each in _LATTICE)
    return x, y, z


def in_cycles(parts: Parts) -> bpy.types.NodeTree:
    """Group of a slot: its lobe, and 1 where the direction ``To`` is not left to it."""
    inputs = lamp_nodes.OUTPUTS | {
        "Random": _VECTOR, "Jitter": _VECTOR, "Step": _VECTOR, "To": _VECTOR,
    }  # fmt: skip
    surface, given, output = Surface.inside("Lamp", parts, inputs, {"Lobe": _SHADER, "Outside": _FLOAT})
    graph, seen = surface.graph, _seen(surface, given)
    # Kinds and sizes are constants to Cycles, which drops the way that is not taken, see `Graph.choose`.
    is_wide = graph.math("GREATER_THAN", graph.product(given["Size"], seen.is_sun), 2.0 * NARROW)
    is_wide = graph.math("MAXIMUM", is_wide, graph.difference(1.0, seen.is_sun))
    near, (far, spread) = _near(graph, given, seen), _far(graph, given, seen)
    to = graph.vector("ADD", graph.scaled(near, graph.difference(1.0, is_wide)), graph.scaled(far, is_wide))
    rgb, _, gain, _ = surface.f_cos(graph.vector("ADD", to, surface["Viewer"]))
    gain = graph.product(gain, graph.choose(is_wide, 1.0, spread))
    red, green, blue = graph.split(rgb)
    gain = surface.limited(gain, red, green, blue)
    s = graph.math("SINE", graph.product(seen.cone, 0.5))
    weight = graph.for_cycles(graph.product(gain, s, s, 4.0 * math.pi * 1e-4))
    node = graph.add("ShaderNodeBsdfToon", component="GLOSSY")
    colour = graph.join(*(graph.for_cycles(each) for each in (red, green, blue)))
    graph.put(node.inputs["Color"], graph.scaled(colour, weight))
    graph.put(node.inputs["Size"], graph.product(seen.cone, 2.0 / math.pi))
    graph.put(node.inputs["Smooth"], 0.0)
    graph.put(node.inputs["Normal"], graph.vector("ADD", seen.axis, surface["Viewer"]))  # Cycles normalises it
    graph.put(output.inputs["Lobe"], surface.mixed(seen.is_on, None, node.outputs[0]))
    cosine = graph.math("COSINE", seen.cone)
    within = graph.math("GREATER_THAN", graph.scalar("DOT_PRODUCT", given["To"], seen.axis), cosine)
    graph.put(output.inputs["Outside"], graph.difference(1.0, graph.product(within, seen.is_on)))
    return graph.tree


def _seen(surface: Surface, lamp: Any) -> Seen:
    graph = surface.graph
    kind, size = lamp["Kind"], lamp["Size"]
    is_sun, is_area = graph.math("LESS_THAN", kind, 1.5), graph.math("GREATER_THAN", kind, 2.5)
    # Products and sums that Cycles can drop, see `Graph.choose`: of a sun nothing here depends on the position.
    from_here = graph.scaled(surface["Position"], graph.difference(1.0, is_sun))
    offset = graph.vector("SUBTRACT", lamp["Place"], from_here)
    u, v = lamp["U"], lamp["V"]
    diagonal = graph.math("SQRT", graph.sum(graph.scalar("DOT_PRODUCT", u, u), graph.scalar("DOT_PRODUCT", v, v)))
    extent = graph.choose(is_area, size, diagonal)
    sine = graph.quotient(extent, graph.scalar("LENGTH", offset))
    of_ball = graph.math("ARCSINE", graph.math("MINIMUM", sine, 1.0))
    radius = graph.choose(is_sun, of_ball, graph.product(size, 0.5))
    cone = graph.math("MAXIMUM", surface["Cone"], graph.fused(radius, 1.02, 0.002))
    return Seen(
        axis=graph.vector("NORMALIZE", offset), radius=radius, cone=graph.math("MINIMUM", cone, 0.5 * math.pi),
        offset=offset, u=u, v=v, is_on=graph.math("GREATER_THAN", kind, 0.5), is_sun=is_sun, is_area=is_area,
        is_rectangle=graph.math("COMPARE", kind, float(slots.KINDS["RECTANGLE"]), 0.25),
    )  # fmt: skip


def _near(graph: Graph, given: Any, seen: Seen) -> Socket:
    """A random direction to a small sun: of the same mean square, the same random numbers for all."""
    to = graph.vector("MULTIPLY_ADD", given["Jitter"], seen.radius, seen.axis)
    return graph.vector("NORMALIZE", to)


def _far(graph: Graph, given: Any, seen: Seen) -> tuple[Socket, Socket]:
    """A random direction to a wide lamp, and the factor that makes the mean uniform in solid angle.

    Suns and balls stand for the disc that they look like. Points are drawn evenly from the lamp's area; solid angle
    per area goes as the cube of one over the distance, in units of its mean over four points that integrate cubics
    over the square or the disc exactly.
    """
    x, y, _ = graph.split(graph.vector("FRACTION", graph.vector("ADD", given["Random"], given["Step"])))
    root, turn = graph.math("SQRT", x), graph.product(y, 2.0 * math.pi)
    square = [graph.fused(each, 2.0, -1.0) for each in (x, y)]
    disc = [graph.product(root, graph.math(name, turn)) for name in ("COSINE", "SINE")]
    place = [graph.choose(seen.is_rectangle, d, s) for s, d in zip(square, disc, strict=True)]
    upright = graph.math("GREATER_THAN", graph.math("ABSOLUTE", graph.split(seen.axis)[2]), 0.7)
    helper = graph.mix(upright, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    side = graph.vector("NORMALIZE", graph.vector("CROSS_PRODUCT", helper, seen.axis))
    other = graph.vector("CROSS_PRODUCT", seen.axis, side)
    tan = graph.math("TANGENT", graph.math("MINIMUM", seen.radius, 1.5))
    tan = graph.product(tan, graph.difference(1.0, seen.is_area))
    u, v = (graph.vector("ADD", graph.scaled(each, tan), h) for each, h in ((side, seen.u), (other, seen.v)))
    middle = graph.mix(seen.is_area, seen.axis, seen.offset)
    to = graph.vector("MULTIPLY_ADD", v, place[1], graph.vector("MULTIPLY_ADD", u, place[0], middle))

    nearness = graph.math("POWER", graph.scalar("LENGTH", to), -3.0)
    part = graph.sum(graph.product(seen.is_rectangle, 1.0 / math.sqrt(3.0) - 0.5), 0.5)
    total: Any = None
    for sign in ("ADD", "SUBTRACT"):
        corner = graph.scaled(graph.vector(sign, u, v), part)
        for way in ("ADD", "SUBTRACT"):
            each = graph.math("POWER", graph.scalar("LENGTH", graph.vector(way, middle, corner)), -3.0)
            total = each if total is None else graph.sum(total, each)
    return graph.vector("NORMALIZE", to), graph.quotient(graph.product(nearness, 4.0), total)


def in_eevee(parts: Parts) -> bpy.types.NodeTree:
    """Group of a slot: the colour that its lamp gives in EEVEE, and 1 where the direction ``To`` is not left to it.

    A white GGX lobe about the half vector is turned into the colour that it shows (Shader to RGB), which brings the
    lamp's light and shadow, divided by the lobe's peak and multiplied by f cos at the lamp's middle. A lobe of the
    colour f cos would go through EEVEE's buffers, which hold colours in ten bits from 0 to 8 and one lobe of several
    at random. The lobe shows the world too, over the solid angle that it covers: directions drawn within it are left to
    the lamp, so that nothing counts twice.
    """
    inputs = lamp_nodes.OUTPUTS | {"To": _VECTOR}
    surface, given, output = Surface.inside("EEVEE lamp", parts, inputs, {"Colour": _VECTOR, "Outside": _FLOAT})
    graph, seen = surface.graph, _seen(surface, given)
    h = graph.vector("ADD", seen.axis, surface["Viewer"])
    rgb, _, gain, _ = surface.f_cos(h)
    # Of the disc with the same mean square as the lamp, over half the diagonal of a rectangle or an ellipse.
    square, disc = math.sqrt(2.0 / 3.0) - math.sqrt(0.5), math.sqrt(0.5) - 1.0
    of_round = graph.fused(seen.is_area, graph.fused(seen.is_rectangle, square, disc), 1.0)
    radius = graph.product(seen.radius, of_round)
    alpha = graph.clamp(graph.product(radius, 2.0), EEVEE_ALPHA, EEVEE_ALPHA_MAX)
    alpha2 = graph.product(alpha, alpha)
    half = graph.vector("NORMALIZE", h)
    light = mirror(graph, half, graph.math("SQRT", alpha))
    c = graph.clamp(graph.scalar("DOT_PRODUCT", half, surface["Viewer"]), 1e-3, 1.0)
    # One over the lobe's peak is 4 c pi alpha^2 (1 + 2 Lambda(c)), with 1 + 2 Lambda = sqrt(1 + alpha^2 tan^2).
    tan2 = graph.difference(graph.math("POWER", c, -2.0), 1.0)
    lambdas = graph.math("SQRT", graph.fused(tan2, alpha2, 1.0))
    solid_angle = graph.product(c, alpha2, lambdas, 4.0 * math.pi / EEVEE_PEAK)
    # The mean of the lobe over the lamp lies below the peak: half vectors turn by half the lamp's radius in the plane
    # of incidence and by 1 / c as much across it, D falls as 1 - 2 (tan / alpha)^2.
    part = graph.quotient(graph.product(radius, 0.5), alpha)
    spread = graph.fused(graph.product(part, part, 0.5), graph.sum(tan2, 2.0), 1.0)
    factor = graph.product(gain, solid_angle, spread, seen.is_on)
    graph.put(output.inputs["Colour"], graph.scaled(graph.vector("MULTIPLY", rgb, light), factor))
    cosine = graph.fused(solid_angle, -0.5 / math.pi, 1.0)
    within = graph.math("GREATER_THAN", graph.scalar("DOT_PRODUCT", given["To"], seen.axis), cosine)
    graph.put(output.inputs["Outside"], graph.difference(1.0, graph.product(within, seen.is_on)))
    return graph.tree


def mirror(graph: Graph, half: Socket, roughness: Value) -> Socket:
    """What EEVEE shows in a white mirror of a normal: lamps with their shadows, and the world or a probe."""
    glossy = graph.add("ShaderNodeBsdfAnisotropic", distribution="GGX")
    graph.put(glossy.inputs["Color"], (1.0, 1.0, 1.0))
    graph.put(glossy.inputs["Roughness"], roughness)
    graph.put(glossy.inputs["Normal"], half)
    shown = graph.add("ShaderNodeShaderToRGB")
    graph.put(shown.inputs[0], glossy.outputs[0])
    return shown.outputs[0]
