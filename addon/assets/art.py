# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the library's prints, made by formulas: what is printed, and where which grating lies.

Each function returns ``(paint, rgb)``: a `Paint` of the structure, and a linear RGB picture ``(rows, cols, 3)``, row 0
at the bottom, or None where no ink is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...precompute.paint import Paint, make_paint

#: Pixels along the longer side of what is printed; width of a card over its height (63 by 88 mm).
SIDE, CARD = 1024, 63.0 / 88.0

Art = tuple[Paint, np.ndarray | None]


def glitter(period_m: float) -> Art:
    """Cells of random direction and period."""
    return make_paint("glitter", period_m, SIDE, cells=60), None


def _plane(width: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """x from -width to width, y from -1 to 1."""
    columns = round(SIDE * width)
    x, y = ((np.arange(n) + 0.5) * (2.0 / SIDE) - n / SIDE for n in (columns, SIDE))
    return tuple(np.meshgrid(x, y))  # type: ignore[return-value]


def _cropped(paint: Paint, columns: int) -> Paint:
    """The middle columns of a square paint."""
    left = (paint.shape[1] - columns) // 2
    scale, depth, rotation, mask = (each[:, left : left + columns] for each in paint.maps)
    return replace(paint, scale=scale, depth=depth, rotation=rotation, mask=mask)


def card(period_m: float) -> Art:
    """A framed picture: dark hills before a sun, whose rays are foil, and stars of another period."""
    x, y = _plane(CARD)
    columns = x.shape[1]
    sun_x, sun_y = 0.08, 0.10
    azimuth = np.arctan2(y - sun_y, x - sun_x)
    away = np.hypot(x - sun_x, y - sun_y)
    rays = np.floor(azimuth / (2.0 * np.pi) * 40.0)
    rotation = azimuth + np.where(np.mod(rays, 2.0) > 0.5, 0.5 * np.pi, 0.0)
    scale = 1.0 - 0.25 * np.mod(np.floor(away * 9.0), 2.0)
    glitter = _cropped(make_paint("glitter", period_m, SIDE, cells=70), columns)

    border = np.maximum(np.abs(x) - (CARD - 0.075), np.abs(y) - (1.0 - 0.075)) > 0.0
    frame = np.maximum(np.abs(x) - (CARD - 0.095), np.abs(y) - (1.0 - 0.095)) > 0.0
    title = (np.abs(y + 0.80) < 0.085) & ~frame
    far = y < -0.16 + 0.13 * np.sin(3.1 * x + 0.4) + 0.06 * np.sin(8.3 * x)
    near = y < -0.42 + 0.11 * np.sin(2.3 * x + 2.2) + 0.04 * np.sin(9.1 * x + 1.0)
    disc = away < 0.22
    ink = far | border | title
    rgb = np.zeros((*x.shape, 3))
    rgb[:] = np.array([0.010, 0.020, 0.075])  # a glaze over the foil
    rgb[disc] = [0.85, 0.36, 0.05]
    rgb[far] = [0.015, 0.055, 0.075]
    rgb[near] = [0.006, 0.020, 0.022]
    snow = far & ~near & (y > -0.20 + 0.13 * np.sin(3.1 * x + 0.4) + 0.06 * np.sin(8.3 * x))
    rgb[snow] = [0.42, 0.50, 0.62]
    rgb[frame] = [0.50, 0.33, 0.08]
    rgb[border] = [0.012, 0.014, 0.030]
    rgb[title] = [0.55, 0.50, 0.40]
    strokes = np.mod(16.0 * x + 3.0 * np.sin(21.0 * np.floor(5.0 * x)), 1.0) < 0.62
    rgb[title & strokes & (np.abs(y + 0.80) < 0.032) & (np.abs(x) < 0.42)] = [0.012, 0.014, 0.030]
    gilt = frame & ~border
    stars = glitter.scale > 0.93
    foil = (~ink & ~disc) | gilt
    where = stars & foil & ~gilt & (away > 0.35)
    rotation = np.where(where, glitter.rotation, rotation)
    scale = np.where(where, 0.8, scale)
    info = {"recipe": "trading card"}
    return Paint(scale, np.ones_like(scale), rotation, foil.astype(np.float32), info), rgb


def sticker(period_m: float) -> Art:
    """A guilloche round a seal of rings with a star, on silver."""
    x, y = _plane()
    away, azimuth = np.hypot(x, y), np.arctan2(y, x)
    lines = make_paint("guilloche", period_m, SIDE, petals=12, lines=22, cover=0.45)
    seal = make_paint("rings", period_m, SIDE, bands=28)
    star = away < 0.34 * (1.0 - 0.42 * np.abs(np.mod(azimuth / (2.0 * np.pi) * 5.0 + 0.25, 1.0) - 0.5) * 2.0)
    inside, ring = away < 0.44, (away > 0.44) & (away < 0.47)
    rotation = np.where(inside, seal.rotation, lines.rotation)
    rotation = np.where(star, azimuth * 0.0 + 0.25 * np.pi + 3.0 * away, rotation)
    scale = np.where(star, 0.75, np.where(inside, 0.9, lines.scale))
    mask = np.where(inside, 1.0, lines.mask) * (away < 0.97) * ~ring
    rgb = np.empty((*x.shape, 3))
    rgb[:] = [0.22, 0.22, 0.23]
    rgb[inside] = [0.03, 0.03, 0.033]
    rgb[ring | (away > 0.97)] = [0.05, 0.005, 0.01]
    return Paint(scale, np.ones_like(scale), rotation, mask, {"recipe": "security sticker"}), rgb


def mark(period_m: float) -> Art:
    """A mark that a laser wrote: rings, a spiral and a scale bar, each part with its own polarisation."""
    x, y = _plane()
    away, azimuth = np.hypot(x, y + 0.0), np.arctan2(y, x)
    turns = np.mod(azimuth / (2.0 * np.pi) + away * 3.0, 1.0)
    spiral = (turns < 0.55) & (away < 0.52)
    ring = np.abs(away - 0.66) < 0.07
    corner = np.maximum(np.abs(x), np.abs(y))
    square = (np.abs(corner - 0.90) < 0.035) & (np.minimum(np.abs(x), np.abs(y)) > 0.35)
    sector = np.floor(azimuth / (2.0 * np.pi) * 18.0)
    rotation = np.where(ring, sector * (np.pi / 9.0), np.where(spiral, azimuth, 0.25 * np.pi))
    mask = (spiral | ring | square).astype(np.float32)
    ones = np.ones_like(x)
    return Paint(ones, ones, rotation, mask, {"recipe": "laser mark"}), None


def brush(period_m: float) -> Art:
    """Hairlines along y, each a pass of one grain: its own spacing of grooves, depth, and a turn of a degree or so.

    The picture repeats itself without a seam.
    """
    random = np.random.default_rng(3)
    count, most = 170, 5
    widths = random.uniform(0.4, 1.6, count)
    hair = np.searchsorted(np.cumsum(widths) / widths.sum(), (np.arange(SIDE) + 0.5) / SIDE)
    parts, start = random.integers(2, most + 1, count), random.uniform(0.0, 1.0, count)
    along = np.mod((np.arange(SIDE)[:, None] + 0.5) / SIDE + start[hair], 1.0)
    part = np.floor(along * parts[hair]).astype(int)
    scale, depth = random.uniform(0.5, 1.0, (count, most)), random.uniform(0.35, 1.0, (count, most))
    turn = random.normal(0.0, np.radians(1.2), (count, most))
    scale, depth, turn = (each[hair, part] for each in (scale, depth, turn))
    return Paint(scale, depth, turn, np.ones_like(scale), {"recipe": "hairlines"}), None


ART = {"brush": brush, "glitter": glitter, "card": card, "sticker": sticker, "mark": mark}
