# SPDX-License-Identifier: GPL-3.0-or-later
"""The lamps of the scene's list as groups: lobes that Cycles aims at them, colours that EEVEE shows."""

from __future__ import annotations

import math

import bpy

from ..node import lamp_nodes
from ..node_graph import Graph, Socket, Value
from . import aimed
from .aimed import holds
from .seen import seen
from .surface import Parts, Surface

_FLOAT, _VECTOR, _SHADER = "NodeSocketFloat", "NodeSocketVector", "NodeSocketShader"

#: As in ``shaders/diffraction.osl``: Cycles drops closures whose weights have a mean below 1e-5.
WEIGHT_MIN = 1.1e-5

#: As in ``shaders/diffraction.osl``: the part of what the surface sends that a thin lamp's whole lobe may show of it,
#: and how many times the mean of f cos it may have.
SLENDER_COUNTS, SLENDER_ABOVE = 0.05, 2.0

#: Slots that EEVEE reads: there each costs whether a lamp is in it or not.
EEVEE_LAMPS_MAX = 4

#: Alpha (roughness squared) of EEVEE's lobe, for small lamps and at most: it is four times as wide as the lamp.
#: Narrower ones its tables of GGX do not hold, wider ones see more of the other lamps and of the world.
EEVEE_ALPHA, EEVEE_ALPHA_MAX = 0.04, 0.25

#: What EEVEE's tables make of the lobe's peak, measured: 0.995 to 0.997 at all angles for the smallest alpha.
EEVEE_PEAK = 0.9957

#: How fast EEVEE's lobe falls about its peak over how fast GGX does, measured: 0.7 to 0.85, by alpha and lamp.
EEVEE_TOP = 0.8


#: EEVEE's threshold where a scene has no world, and how many times it the world may be.
SUN_THRESHOLD, WORLD_MARGIN = 10.0, 4.0


#: How much wider than the lamp, and by how many radians for a disc, what drawn directions must not show.
EEVEE_EDGE, EEVEE_BESIDE = 1.2, 0.03


def grey_of(graph: Graph, rgb: Socket) -> Socket:
    """Mean of a colour's channels."""
    return graph.scalar("DOT_PRODUCT", rgb, (1.0 / 3.0,) * 3)


def in_cycles(parts: Parts) -> bpy.types.NodeTree:
    """Group of a slot, handed what `aimed` and `seen.hits` give and a random number: its lobe, and f cos in it, grey.

    Cycles steps over what a Mix Shader's factor leaves out, and over nothing else. So there are three lobes: a plain
    one, one where albedos may pass 1, and one for diffuse rays and dim lobes.
    """
    inputs = {
        "To": _VECTOR, "Aim": _VECTOR, "Width": _FLOAT, "Weight": _FLOAT, "Narrow": _FLOAT, "On": _FLOAT,
        "Hits": _FLOAT, "Chance": _FLOAT, "Sent": _FLOAT,
    } | aimed.SLENDER  # fmt: skip
    outputs = {"Lobe": _SHADER, "Grey": _FLOAT, "Slender": _FLOAT}
    surface, given, output = Surface.inside("Lamp", parts, inputs, outputs)
    graph = surface.graph
    h = graph.vector("ADD", given["To"], surface["Viewer"])
    rgb, plain, finished, is_more = surface.f_cos(h)
    # What stands in a whole lobe's cone is that lobe's; whole lobes that hold each other's lamps share.
    taken = graph.fused(given["Hits"], graph.fused(given["Narrow"], 1e8, 1.0), 1.0)
    weight = graph.quotient(given["Weight"], taken)
    grey = grey_of(graph, rgb)
    # A lobe that holds a thin lamp would show too much of what surrounds it, as in ``shaders/diffraction.osl``.
    here = graph.product(grey, plain)
    shows = graph.math("GREATER_THAN", graph.product(here, weight), graph.product(given["Sent"], SLENDER_COUNTS))
    peaks = graph.math("GREATER_THAN", here, graph.product(given["Sent"], SLENDER_ABOVE / math.pi))
    shows = graph.product(shows, peaks, graph.math("LESS_THAN", given["Hits"], 0.5), 0.01)
    is_slender = graph.product(given["Slender"], graph.for_cycles(shows))
    weight = graph.choose(is_slender, weight, given["SlenderWeight"])
    width = graph.choose(is_slender, given["Width"], given["SlenderWidth"])
    size = graph.product(width, 2.0 / math.pi)
    aim = graph.mix(is_slender, given["Aim"], given["SlenderAim"])
    normal = graph.vector("ADD", aim, surface["Viewer"])  # Cycles normalises it

    def lobe(hundredth: Socket) -> Socket:
        node = graph.add("ShaderNodeBsdfToon", component="GLOSSY")
        # What EEVEE needs for the factors below it computes anyway: only what comes on top is kept from it.
        graph.put(node.inputs["Color"], graph.scaled(rgb, graph.for_cycles(hundredth)))
        graph.put(node.inputs["Size"], size)
        graph.put(node.inputs["Smooth"], 0.0)
        graph.put(node.inputs["Normal"], normal)
        return node.outputs[0]

    graph.put(output.inputs["Grey"], graph.product(grey, plain))
    graph.put(output.inputs["Slender"], is_slender)
    plain = graph.product(plain, weight)

    def is_dim(gain: Socket) -> Socket:
        return graph.math("LESS_THAN", graph.product(grey, gain), WEIGHT_MIN)

    whole = graph.product(finished, weight)
    limited = graph.product(surface.limited(finished, *graph.split(rgb)), weight)
    rare = lobe(kept(graph, grey, limited, given["Chance"]))
    more = lobe(graph.product(whole, 0.01))
    more = surface.mixed(graph.math("MAXIMUM", is_dim(whole), surface["IsDiffuse"]), more, rare)
    either = surface.mixed(graph.math("MAXIMUM", is_more, is_dim(plain)), lobe(graph.product(plain, 0.01)), more)
    # Nothing of this is computed for a lamp below the horizon, unless a direction from the environment asks for it.
    above = surface.mixed(surface.is_above(h), None, either)
    graph.put(output.inputs["Lobe"], surface.mixed(given["On"], None, above))
    return graph.tree


def kept(graph: Graph, grey: Socket, gain: Socket, chance: Socket) -> Socket:
    """A hundredth of a factor of a colour such that Cycles does not drop the closure: dim ones stay now and then.

    As ``kept`` in ``shaders/diffraction.osl``; the colour's mean, the factor, a random number times `WEIGHT_MIN`.
    """
    mean = graph.product(grey, gain)
    stays = graph.math("GREATER_THAN", mean, chance)
    raised = graph.math("MAXIMUM", graph.quotient(WEIGHT_MIN, mean), 1.0)
    return graph.product(graph.product(stays, 0.01), raised, gain)


def in_eevee(parts: Parts) -> bpy.types.NodeTree:
    """Group of a slot: the colour that its lamp gives in EEVEE, and 1 where the direction ``To`` is not left to it.

    A white GGX lobe about the half vector is turned into the colour that it shows (Shader to RGB), which brings the
    lamp's light and shadow, divided by the lobe's peak and multiplied by f cos at the lamp's middle. A lobe of the
    colour f cos would go through EEVEE's buffers, which hold colours in ten bits from 0 to 8 and one lobe of several
    at random. The lobe shows the world too, over the solid angle that it covers: directions ``To`` drawn within it are
    left to the lamp, so that nothing counts twice, as far as f cos there is that at the lamp's middle. Where it is more
    (``Drawn``) the rest of it is drawn still, but for what shows the lamp itself: a wide lobe beside a mirror's narrow
    peak would leave a dark ring. A sun that brings its light along (`lights.worlds`: places of an image from which
    EEVEE's own sun does not come) shows that, and hides nothing of the world.
    """
    inputs = lamp_nodes.OUTPUTS | {"To": _VECTOR, "Drawn": _FLOAT}
    surface, given, output = Surface.inside("EEVEE lamp", parts, inputs, {"Colour": _VECTOR, "Outside": _FLOAT})
    graph = surface.graph
    lamp = seen(graph, surface["Position"], given)
    h = graph.vector("ADD", lamp.axis, surface["Viewer"])
    rgb, _, gain, _ = surface.f_cos(h)
    # Of the disc with the same mean square as the lamp, over half the diagonal of a rectangle or an ellipse.
    square, disc = math.sqrt(2.0 / 3.0) - math.sqrt(0.5), math.sqrt(0.5) - 1.0
    of_round = graph.fused(lamp.is_area, graph.fused(lamp.is_rectangle, square, disc), 1.0)
    radius = graph.product(lamp.radius, of_round)
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
    # of incidence and by 1 / c as much across it. Over such an ellipse the mean of (1 + (tan / alpha)^2)^-2 is
    # 1 / sqrt((1 + p^2) (1 + p^2 / c^2)), with p the lesser half axis over alpha.
    part = graph.quotient(graph.product(radius, 0.5), alpha)
    part2 = graph.product(part, part, EEVEE_TOP)
    along, across = graph.sum(part2, 1.0), graph.fused(part2, graph.sum(tan2, 1.0), 1.0)
    spread = graph.math("SQRT", graph.product(along, across))
    is_own = graph.product(lamp.is_sun, graph.math("GREATER_THAN", graph.scalar("DOT_PRODUCT", lamp.u, lamp.u), 0.0))
    of_lobe = graph.scaled(light, graph.product(solid_angle, spread, graph.difference(1.0, is_own)))
    shines = graph.vector("ADD", of_lobe, graph.scaled(lamp.u, is_own))
    graph.put(
        output.inputs["Colour"], graph.scaled(graph.vector("MULTIPLY", rgb, shines), graph.product(gain, lamp.is_on))
    )
    cosine = graph.fused(solid_angle, -0.5 / math.pi, 1.0)
    drawn = graph.scalar("DOT_PRODUCT", given["To"], lamp.axis)
    within = graph.math("GREATER_THAN", drawn, cosine)
    here = graph.product(grey_of(graph, rgb), gain)
    share = graph.math("MINIMUM", graph.quotient(here, given["Drawn"]), 1.0)
    edge = graph.math("COSINE", graph.fused(lamp.radius, EEVEE_EDGE, EEVEE_BESIDE))
    beside = (-EEVEE_EDGE,) * 2, (EEVEE_EDGE,) * 2
    hit = graph.choose(lamp.is_area, graph.math("GREATER_THAN", drawn, edge), holds(graph, given["To"], lamp, *beside))
    taken = graph.math("MAXIMUM", graph.product(within, share), hit)
    graph.put(
        output.inputs["Outside"], graph.difference(1.0, graph.product(taken, lamp.is_on, graph.difference(1.0, is_own)))
    )
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


def most_of_world(graph: Graph) -> Socket:
    """A vector of the radiance that EEVEE's world has at most, some times over for what the strength of a view adds.

    What is brighter EEVEE turns into a sun (*Sun > Threshold* of the world), which a mirror without roughness meets
    once in 50,000 times: a white dot. Where the threshold is 0 there is no bound.
    """
    read = graph.add("ShaderNodeAttribute", attribute_type="VIEW_LAYER", attribute_name="sun_threshold").outputs
    without_world = graph.fused(read["Alpha"], -WORLD_MARGIN * SUN_THRESHOLD, WORLD_MARGIN * SUN_THRESHOLD)
    most = graph.fused(read["Fac"], WORLD_MARGIN, without_world)
    most = graph.sum(most, graph.product(graph.math("LESS_THAN", most, 1e-3), 1e6))
    return graph.join(most, most, most)
