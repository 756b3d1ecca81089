# SPDX-License-Identifier: GPL-3.0-or-later
"""A sheet of overlapping scales in numpy: which scale covers a place, and the height of its surface there."""

import numpy as np

BULGE, EDGE, ROOT, KEEL = 0.16, 0.22, 0.20, 0.22
RISE, DOME, EDGE_DROP, ROOT_DROP = 0.10, 0.055, 0.045, 0.03


def covering(x, y):
    """Numbers (along, around) of the scale, and the place on it (f, g), by search among the neighbours.

    A place belongs to the scale whose two diagonal strips hold it; each strip ends in a line of bulges, one a scale.
    """
    s, t = x + y / 2, x - y / 2
    found = np.full((*x.shape, 2), -(10**6))
    place = np.full((*x.shape, 2), np.nan)
    for di in (-2, -1, 0, 1, 2):
        for dj in (-2, -1, 0, 1, 2):
            i, j = np.floor(s) + di, np.floor(t) + dj
            f = s - _bulges(t) - i
            g = t - _bulges(s) - j
            inside = (f >= 0) & (f < 1) & (g >= 0) & (g < 1)
            assert not (inside & (found[..., 0] > -(10**6))).any()  # no place belongs to two
            found[inside] = np.stack([i + j, i - j], -1)[inside]
            place[inside] = np.stack([f, g], -1)[inside]
    assert (found[..., 0] > -(10**6)).all()  # each belongs to one
    return found.astype(int), place


def _bulges(t):
    """A row of parabolas of height BULGE."""
    middle = np.floor(t) + 0.5
    return BULGE * (1 - (2 * (t - middle)) ** 2)


def height(x, y, keel=0.0):
    """Over the length of a scale."""
    _, place = covering(x, y)
    f, g = place[..., 0], place[..., 1]
    c = f - g
    result = RISE * (f + g) / 2 - DOME * c**2 + keel * np.maximum(0, 1 - np.abs(c) / KEEL)
    for each in (f, g):
        result = result - EDGE_DROP * np.maximum(0, (each - 1 + EDGE) / EDGE) ** 2
        result = result - ROOT_DROP * np.maximum(0, (ROOT - each) / ROOT) ** 2
    return result
