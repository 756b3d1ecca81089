# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedos of a surface stretched by s and deepened by q, for a few (s, q).

With ``T'(u, v, w) = s^2 T(s u, s v, q w)`` and (u', v') = s (u, v) the albedo of the scaled surface is the table's own
integral with other weights (R = 1):

    a(wr; s, q) = integral (1 + wi.wr)^2 / (cos_i cos_r w^2) T(u', v', q w) du' dv',    wi_xy = -(u', v') / s - wr_xy

It is summed on coarse rings and sectors, relative to the surface as baked, and that ratio multiplies the table's own.
What renderers look up is a row of tiles over (theta, phi), one a scale, ``STEPS`` to an octave; the three channels hold
three depths. Between scales it is linear in log s, between depths quadratic in q. Lines of order that pass the horizon
between two scales would be missed: a tile holds at least what the scales halfway to its neighbours need, so that no
light is made, and some is lost within a few degrees of such a line. What single wavelengths need beyond X, Y and Z is
in the table's sidecar (`scaled_bound`).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from . import scaled_bound
from .albedo import DARK_WHITE
from .cells import Cells, Slices, folded
from .table import SpectralTable

#: Tiles, and how many of them halve the scale; the first is the largest scale (1, or the table's headroom).
N_SCALES, STEPS = 25, 8

#: The depths of the three channels over the largest depth.
DEPTHS = (1.0, 0.6, 0.2)

#: Bounds of single wavelengths up to here are as good as 1: so far the sums over few angles err.
BOUND_SLACK = 1.01

#: Size of a tile without its guard rows; tables have the same by default.
N_THETA, N_PHI = 46, 36

#: Size of all tiles together.
WIDTH, HEIGHT = N_SCALES * N_THETA, N_PHI + 2

#: Polar angles (radians), azimuths and sectors of the coarse sums, and the width of rings over their radius.
_THETAS, _AZIMUTHS, _SECTORS, _RING = scaled_bound.THETAS, scaled_bound.N_AZIMUTHS, 48, 0.05

#: Scales that a thread looks at at a time.
_AT_A_TIME = 3


def place(scale: np.ndarray | float, depth: np.ndarray | float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the albedo of a scale and depth is found.

    Parameters
    ----------
    scale, depth
        Over the largest that the table holds; what lies outside of the tiles takes the nearest.

    Returns
    -------
    tuple of ndarray
        Index of the lower tile, the part of the next one, and ``(..., 3)`` weights of the channels.
    """
    at = np.clip(-STEPS * np.log2(np.maximum(scale, 1e-9)), 0.0, N_SCALES - 1.0)
    lower = np.minimum(np.floor(at), N_SCALES - 2.0)
    q, (a, b, c) = np.clip(depth, DEPTHS[-1], DEPTHS[0]), DEPTHS
    weights = [
        (q - b) * (q - c) / ((a - b) * (a - c)), (q - a) * (q - c) / ((b - a) * (b - c)),
        (q - a) * (q - b) / ((c - a) * (c - b)),
    ]  # fmt: skip
    return lower.astype(int), at - lower, np.stack(weights, -1)


def look_up(tiles: np.ndarray, directions: np.ndarray, scale: np.ndarray, depth: np.ndarray) -> np.ndarray:
    """Albedos as renderers look them up.

    Parameters
    ----------
    tiles
        ``(HEIGHT, WIDTH, 3)``, see `scaled_albedos`.
    directions
        ``(..., 3)`` unit vectors in the scan's frame.
    scale, depth
        Over the largest that the table holds, ``(...)``.
    """
    directions = np.asarray(directions, float)
    theta = np.arccos(np.clip(directions[..., 2], 0.0, 1.0))
    turn = np.arctan2(directions[..., 1], directions[..., 0]) / (2.0 * np.pi)
    column, row = theta * ((N_THETA - 1) / (0.5 * np.pi)), 1.0 + np.mod(turn * N_PHI, N_PHI)
    lower, part, weights = place(scale, depth)
    left, below = np.minimum(column.astype(int), N_THETA - 2), np.minimum(row.astype(int), N_PHI)
    fx, fy = column - left, row - below

    def tile(index: np.ndarray) -> np.ndarray:
        x = index * N_THETA + left
        low, high = (
            tiles[y, x] * (1 - fx)[..., None] + tiles[y, x + 1] * fx[..., None] for y in (below, below + 1)
        )  # fmt: skip
        return ((low * (1 - fy)[..., None] + high * fy[..., None]) * weights).sum(-1)

    return tile(lower) * (1 - part) + tile(lower + 1) * part


def scaled_albedos(table: SpectralTable) -> np.ndarray:
    """The tiles of a table.

    Parameters
    ----------
    table
        The spectral table.

    Returns
    -------
    ndarray
        ``(HEIGHT, WIDTH, 3)`` float32, row 0 at the bottom: tiles side by side, each with a guard row below and above.
    """
    most_s, most_q = table.headroom
    scales = 2.0 ** (np.arange(2 * N_SCALES - 1) / (-2.0 * STEPS))
    ratios = albedo_ratios(table, [(most_s * s, most_q * q) for s in scales for q in DEPTHS])
    ratios = ratios.reshape(len(scales), len(DEPTHS), *ratios.shape[1:])
    albedo, conserving = (_on_grid(each) for each in (table.albedo, table.conserving_albedo))
    needed = np.stack([[_on_tile(each) * albedo for each in node] for node in ratios])  # (scale, depth, phi, theta)
    bound = scaled_bound.unpack(table.info)
    if bound is None:
        # Baked before it was kept: it is taken as that of the table, growing with the depth.
        excess = conserving / np.maximum(albedo, 1e-6) - 1.0
        needed *= (1.0 + excess * np.minimum(np.multiply(DEPTHS, most_q), 1.0)[:, None, None])[None]
    else:
        for node, scale in zip(needed, scales, strict=True):
            for own, least in zip(node, scaled_bound.between(bound, scale), strict=False):
                least = _on_tile(least, np.maximum)
                own[:] = np.where(least > BOUND_SLACK, np.maximum(own, least), own)
    tiles = needed[::2].copy()
    tiles[:-1] = np.maximum(tiles[:-1], needed[1::2])
    tiles[1:] = np.maximum(tiles[1:], needed[1::2])
    if table.headroom == (1.0, 1.0):
        tiles[0, 0] = conserving  # of the surface as baked it is known, and OSL looks it up elsewhere
    tiles = np.concatenate([tiles[:, :, -1:], tiles, tiles[:, :, :1]], axis=2)
    return np.ascontiguousarray(tiles.transpose(2, 0, 3, 1).reshape(HEIGHT, WIDTH, 3).astype(np.float32))


def albedo_ratios(table: SpectralTable, pairs: list[tuple[float, float]]) -> np.ndarray:
    """``(pairs, thetas, azimuths)`` albedos of a table at scales and depths over that at 1, on the bounds' angles.

    Parameters
    ----------
    table
        The spectral table.
    pairs
        Scales and depths.
    """
    sums = _Sums(table)
    scales = list(dict.fromkeys(scale for scale, _ in pairs))
    depths = list(dict.fromkeys(depth for _, depth in pairs))
    parts = [scales[start : start + _AT_A_TIME] for start in range(0, len(scales), _AT_A_TIME)]
    with ThreadPoolExecutor(min(os.cpu_count() or 1, 8)) as pool:
        found = np.concatenate(list(pool.map(lambda part: sums.albedos(part, depths), parts)))
    own = sums.albedos([1.0], [1.0])[0, 0]
    rows = [found[scales.index(scale), depths.index(depth)] for scale, depth in pairs]
    return np.stack(rows) / np.maximum(own, 1e-6)


def _on_grid(albedo: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
    """``(N_PHI, N_THETA)`` albedos of a table."""
    phi, theta = (np.arange(N_PHI) * (2.0 * np.pi / N_PHI))[:, None], np.arange(N_THETA) * (0.5 * np.pi / (N_THETA - 1))
    sine = np.sin(theta)
    shape = (N_PHI, N_THETA)
    parts = (sine * np.cos(phi), sine * np.sin(phi), np.broadcast_to(np.cos(theta), shape))
    return albedo(np.stack(parts, -1))


def _on_tile(values: np.ndarray, around: np.ufunc | None = None) -> np.ndarray:
    """``(N_PHI, N_THETA)`` from ``(thetas, azimuths)``, linear between them, or what `around` makes of two azimuths."""
    tile_theta = np.arange(N_THETA) * (0.5 * np.pi / (N_THETA - 1))
    at = np.arange(N_PHI) * (_AZIMUTHS / N_PHI)
    lower, upper = np.floor(at + 1e-9).astype(int), np.ceil(at - 1e-9).astype(int)
    low, high, part = values[:, lower % _AZIMUTHS], values[:, upper % _AZIMUTHS], at - lower
    turned = low * (1.0 - part) + high * part if around is None else around(low, high)
    return np.stack([np.interp(tile_theta, _THETAS, column) for column in turned.T])


class _Sums:
    """Coarse sums of a table's light, see `albedos`."""

    def __init__(self, table: SpectralTable) -> None:
        layout = table.layout
        radii = layout.radii
        starts, start = [], 0
        while start < len(radii):
            starts.append(start)
            start = max(start + 1, int(np.searchsorted(radii, radii[start] * (1.0 + _RING))))
        step = np.diff(radii)
        area = np.zeros(len(radii))  # of hat functions over r dr
        area[:-1] += step * (2.0 * radii[:-1] + radii[1:]) / 6.0
        area[1:] += step * (radii[:-1] + 2.0 * radii[1:]) / 6.0
        self._r = np.add.reduceat(area * radii, starts) / np.add.reduceat(area, starts)
        self._width = np.append(radii[starts][1:], radii[-1]) - radii[starts]
        self._count, self._index = min(_SECTORS, layout.n_phi), layout.index
        self._slices = Slices(layout, gain=True)
        white = np.asarray(table.info["colour"]["white_xyz"], float)
        bright = white > DARK_WHITE
        weight = np.zeros((len(radii), len(starts)), np.float32)  # of each radius in its ring
        weight[np.arange(len(radii)), np.repeat(np.arange(len(starts)), np.diff(np.append(starts, len(radii))))] = area
        edges = np.minimum((np.arange(self._count) * layout.n_phi) // self._count, layout.n_phi - 1)
        sizes = np.diff(np.append(edges, layout.n_phi)).astype(np.float32)[:, None]
        scale = (layout.scale / white[bright]).astype(np.float32)

        def rings(index: int) -> np.ndarray:
            """``(colours, rings, sectors)`` light of a slice."""
            x, y = layout.tile_origin(index)
            tile = table.atlas[y + 1 : y + 1 + layout.n_phi, x : x + layout.n_r].astype(np.float32)
            sectors = np.add.reduceat(tile.reshape(layout.n_phi, -1), edges, axis=0) / sizes
            by_colour = sectors.reshape(self._count, layout.n_r, 3).transpose(2, 0, 1)[bright]
            return (by_colour @ weight).transpose(0, 2, 1) * scale[:, None, None]

        with ThreadPoolExecutor(min(os.cpu_count() or 1, 8)) as pool:
            light = np.stack(list(pool.map(rings, range(layout.n_w))))
        # (n_w, colours, rings, half, azimuths) -> columns of (azimuths, colours) by slice, ring and half sector
        pairs = folded(light, _AZIMUTHS).transpose(0, 2, 3, 4, 1)
        self._light = np.ascontiguousarray(pairs).reshape(*pairs.shape[:3], -1)

    def albedos(self, scales: list[float], depths: list[float]) -> np.ndarray:
        """``(scales, depths, thetas, azimuths)`` the largest of X, Y and Z relative to white of surfaces so scaled."""
        r, width = ([each / scale for scale in scales] for each in (self._r, self._width))
        cells = Cells(r, width, self._count, _THETAS, self._index)
        found = np.stack([cells.undivided(self._light, self._slices, depth) for depth in depths], axis=1)
        return np.maximum(found.reshape(*found.shape[:3], _AZIMUTHS, -1).max(-1), 0.0)
