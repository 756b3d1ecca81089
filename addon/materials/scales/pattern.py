# SPDX-License-Identifier: GPL-3.0-or-later
"""The pigment of a snake: ground, flanks, saddles with borders, belly, the skin between scales."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..node_graph import Graph, Socket, Value

#: How far a border keeps to whole scales: 0 runs through them, 1 follows their edges.
BY_SCALE = 0.6

#: Half length (of the spacing) and half width (of the girth) of saddles and of blotches beside them; where these lie.
SADDLE, BLOTCH, BESIDE = (0.33, 0.155), (0.17, 0.05), 0.275

#: Where the pigment within ends and the border ends, of that half size.
INNER, OUTER = 0.80, 1.02


@dataclass
class Place:
    """What is known of a place on the skin.

    Parameters
    ----------
    x, x_middle
        Way along the body here and in the scale's middle, in lengths of scales.
    here, middle
        Distance from the spine in girths, here and there.
    root, across
        Distance from the edges that lie under other scales, from the midline; 0 to 1.
    belly, plates
        How much belly, whether there are plates.
    cell
        Names the scale.
    """

    x: Socket
    x_middle: Socket
    here: Socket
    middle: Socket
    root: Socket
    across: Socket
    belly: Socket
    plates: Socket
    cell: Socket


def smooth(g: Graph, value: Value, low: float, high: float) -> Socket:
    """0 below, 1 above, smooth between."""
    node: Any = g.add("ShaderNodeMapRange", interpolation_type="SMOOTHSTEP")
    g.put(node.inputs["Value"], value)
    node.inputs["From Min"].default_value, node.inputs["From Max"].default_value = low, high
    return node.outputs["Result"]


def colour(g: Graph, given: Any, at: Place, random: Socket) -> Socket:
    """Linear RGB of the pigment; ``random`` is a number of each scale, 0 to 1."""
    x = g.fused(g.difference(at.x_middle, at.x), BY_SCALE, at.x)
    away = g.fused(g.difference(at.middle, at.here), BY_SCALE, at.here)
    ground = g.mix(smooth(g, away, 0.14, 0.33), given["Ground"], given["Side"])
    inner, border = _saddles(g, given, x, away)
    painted = g.mix(border, ground, given["Border Colour"])
    painted = g.mix(inner, painted, given["Saddle Colour"])
    painted = g.mix(at.belly, painted, _belly(g, given, at))
    # Scales differ, and each darkens a little towards its root.
    varied = g.fused(g.product(given["Variation"], g.difference(1.0, at.belly)), g.difference(random, 0.5), 1.0)
    painted = g.scaled(painted, g.product(varied, g.fused(smooth(g, at.root, 0.0, 0.6), 0.25, 0.75)))
    gap = smooth(g, at.root, 0.02, 0.09)
    return g.vector("MAXIMUM", g.mix(g.math("MAXIMUM", gap, at.plates), given["Gap Colour"], painted), (0.0, 0.0, 0.0))


def _saddles(g: Graph, given: Any, x: Socket, away: Socket) -> tuple[Socket, Socket]:
    """How much is within, and within or border: saddles over the back, and blotches that stand beside the gaps."""
    step = g.quotient(x, given["Saddle Spacing"])
    noise: Any = g.add("ShaderNodeTexNoise", noise_dimensions="3D")
    g.put(noise.inputs["Vector"], g.join(g.product(step, 2.2), g.product(away, 7.0), g.fused(given["Seed"], 3.7, 0.5)))
    noise.inputs["Scale"].default_value, noise.inputs["Detail"].default_value = 1.0, 1.0
    wander = g.difference(noise.outputs[0], 0.5)
    step = g.fused(wander, 0.22, step)
    saddle = _blot(g, step, away, SADDLE, 0.0, 3.0)
    beside = _blot(g, g.sum(step, 0.5), away, BLOTCH, BESIDE, 2.0)
    far = g.fused(wander, 0.35, g.math("MINIMUM", saddle, beside))
    inner = g.product(given["Saddles"], g.difference(1.0, smooth(g, far, INNER - 0.03, INNER + 0.03)))
    return inner, g.product(given["Saddles"], g.difference(1.0, smooth(g, far, OUTER - 0.03, OUTER + 0.03)))


def _blot(g: Graph, step: Socket, away: Socket, size: tuple[float, float], at: float, power: float) -> Socket:
    """Distance from a row of blotches in their own half sizes."""
    u = g.math("ABSOLUTE", g.difference(g.math("FRACT", step), 0.5))
    v = g.math("ABSOLUTE", g.difference(away, at))
    parts = [g.math("POWER", g.product(part, 1.0 / half), power) for part, half in zip((u, v), size, strict=True)]
    return g.math("POWER", g.sum(*parts), 1.0 / power)


def _belly(g: Graph, given: Any, at: Place) -> Socket:
    """Plates, some of them black by halves and quarters."""
    quarter = g.math("FLOOR", g.product(at.across, 1.999))
    node: Any = g.add("ShaderNodeTexWhiteNoise", noise_dimensions="3D")
    pair = g.math("FLOOR", g.product(g.split(at.cell)[0], 0.5))
    g.put(node.inputs["Vector"], g.join(pair, g.fused(given["Seed"], 5.0, quarter), 31.0))
    black = g.math("LESS_THAN", node.outputs["Value"], given["Chequer"])
    edge = smooth(g, at.root, 0.0, 0.2)
    plate = g.scaled(given["Belly Colour"], g.fused(edge, 0.35, 0.65))
    return g.mix(black, plate, given["Border Colour"])
