# SPDX-License-Identifier: GPL-3.0-or-later
"""One plane sheet of overlapping scales as shader nodes.

``x`` runs along the body towards the tail in lengths of a scale, ``y`` around it in half widths. Diagonal rows cross in
``s = x + y / 2`` and ``t = x - y / 2``; a scale is a cell of both. Its free edges bulge over the scales behind it:

    s' = s - b q(t),   t' = t - b q(s),   q(f) = 4 frac(f) (1 - frac(f))

which is one-to-one for b < 1/4, and whole numbers of s' and t' are the free edges. So ``floor`` names the scale without
a search among neighbours, the fractions ``f, g`` tell the place on it (root at 0, 0, tip at 1, 1), and the slope of its
height follows in closed form: no bump node, whose finite differences turn an edge into a line as wide as a pixel.

Height of a scale over its length, with ``a = (f + g) / 2`` from root to tip and ``c = f - g`` across:

    rise a - dome c^2 - edge (e(f) + e(g)) - root (r(f) + r(g)) + keel k(c)

e and r are squares that begin near free edge and root, k is a tent on the midline.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..node_graph import Graph, Socket, shared_group

#: Name of the group.
NAME = "Diffraction Scale Lattice"

#: Bulge b of the free edges; widths of rounded edge, root and keel; heights over the scale's length.
BULGE, EDGE, ROOT, KEEL_WIDTH = 0.16, 0.22, 0.20, 0.22
RISE, DOME, EDGE_DROP, ROOT_DROP = 0.10, 0.055, 0.045, 0.03

INPUTS: dict[str, tuple[str, object]] = {
    "X": ("NodeSocketFloat", 0.0),
    "Y": ("NodeSocketFloat", 0.0),
    "Rows": ("NodeSocketFloat", 0.0),
    "Keel": ("NodeSocketFloat", 0.0),
}
OUTPUTS = {
    "Cell": "NodeSocketVector",  # number along, number around (within Rows, where that is not 0), 0
    "Centre": "NodeSocketVector",  # x, y of the scale's middle
    "Slope": "NodeSocketVector",  # of the height along x and y, in lengths of a scale
    "Shape": "NodeSocketVector",  # height; distance to the root's edges; distance across from the midline, |c|
}


def build() -> bpy.types.NodeTree:
    """The group, made where there is none."""
    return shared_group(NAME, INPUTS, OUTPUTS, _fill)


def _fill(g: Graph, given: Any, wanted: Any) -> None:
    x, y = given["X"], given["Y"]
    half = g.product(y, 0.5)
    s, t = g.sum(x, half), g.difference(x, half)
    ps, pt = g.math("FRACT", s), g.math("FRACT", t)
    bent_s, bent_t = g.difference(s, _bulge(g, pt)), g.difference(t, _bulge(g, ps))
    i, j = g.math("FLOOR", bent_s), g.math("FLOOR", bent_t)
    f, h = g.difference(bent_s, i), g.difference(bent_t, j)
    along, around = g.sum(i, j), g.difference(i, j)
    wrapped = g.math("FLOORED_MODULO", around, g.math("MAXIMUM", given["Rows"], 1.0))
    has_rows = g.math("GREATER_THAN", given["Rows"], 0.5)
    number = g.sum(g.product(has_rows, wrapped), g.product(g.difference(1.0, has_rows), around))

    across = g.difference(f, h)
    size = g.math("ABSOLUTE", across)
    side = g.math("SIGN", across)
    keel = g.math("MAXIMUM", g.difference(1.0, g.product(size, 1.0 / KEEL_WIDTH)), 0.0)
    slopes, heights = [], []
    for place in (f, h):
        free = g.math("MAXIMUM", g.product(g.difference(place, 1.0 - EDGE), 1.0 / EDGE), 0.0)
        root = g.math("MAXIMUM", g.product(g.difference(ROOT, place), 1.0 / ROOT), 0.0)
        heights.append(g.sum(g.product(free, free, EDGE_DROP), g.product(root, root, ROOT_DROP)))
        slope = g.sum(g.product(free, -2.0 * EDGE_DROP / EDGE), g.product(root, 2.0 * ROOT_DROP / ROOT))
        slopes.append(g.sum(slope, 0.5 * RISE))
    height = g.product(g.product(g.sum(f, h), 0.5), RISE)
    height = g.difference(height, g.product(across, across, DOME))
    height = g.difference(height, g.sum(heights[0], heights[1]))
    height = g.fused(given["Keel"], keel, height)
    # The dome and the keel lean to both sides.
    ridge = g.product(given["Keel"], g.product(side, g.math("CEIL", keel)), -1.0 / KEEL_WIDTH)
    lean = g.fused(across, -2.0 * DOME, ridge)
    by_f, by_g = g.sum(slopes[0], lean), g.difference(slopes[1], lean)
    warp_t, warp_s = _bulge_slope(g, pt), _bulge_slope(g, ps)
    slope_x = g.sum(g.product(by_f, g.difference(1.0, warp_t)), g.product(by_g, g.difference(1.0, warp_s)))
    slope_y = g.product(
        g.difference(g.product(by_f, g.sum(1.0, warp_t)), g.product(by_g, g.sum(1.0, warp_s))), 0.5
    )  # fmt: skip

    g.put(wanted["Cell"], g.join(along, number, 0.0))
    g.put(wanted["Centre"], g.join(g.product(g.sum(along, 1.0), 0.5), around, 0.0))
    g.put(wanted["Slope"], g.join(slope_x, slope_y, 0.0))
    g.put(wanted["Shape"], g.join(height, g.math("MINIMUM", f, h), size))


def _bulge(g: Graph, f: Socket) -> Socket:
    """b q(f)."""
    return g.product(g.product(f, g.difference(1.0, f)), 4.0 * BULGE)


def _bulge_slope(g: Graph, f: Socket) -> Socket:
    """Slope of b q(f)."""
    return g.fused(f, -8.0 * BULGE, 4.0 * BULGE)
