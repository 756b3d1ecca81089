# SPDX-License-Identifier: GPL-3.0-or-later
"""A coiled snake's body with overlapping scales, as plain arrays."""

from __future__ import annotations

import numpy as np

#: Turns of the coil, scales around the body and rings of vertices a scale.
TURNS, AROUND, RINGS_A_SCALE, SIDES_A_SCALE = 2.654, 26, 11, 13


def centre_line(t: np.ndarray) -> np.ndarray:
    """Points of a flat coil that opens from the tail (t = 0) to the neck (t = 1), body resting on z = 0."""
    angle = 2 * np.pi * TURNS * t + 0.6
    distance = 0.16 + 0.30 * angle / (2 * np.pi) + 0.02 * np.sin(3 * angle)
    radius = body_radius(t)
    return np.stack(
        [distance * np.cos(angle), distance * np.sin(angle), 0.92 * radius + 0.015 * np.sin(2.3 * angle) ** 2], -1
    )


def body_radius(t: np.ndarray) -> np.ndarray:
    """Radius of the body: a tail that tapers to a point."""
    return 0.004 + 0.142 * np.clip(t / 0.62, 0, 1) ** 0.62


def scale_height(along: np.ndarray, across: np.ndarray) -> np.ndarray:
    """Height of overlapping scales, about 0..1, in lattice coordinates (one scale a unit, rows staggered).

    Each scale is a pointed leaf, domed across and along, that rises towards its free end and lies over the next.
    """
    height = np.zeros_like(along)
    row = np.floor(across)
    for dr in (-1, 0, 1):
        for dc in (-1, 0, 1, 2):
            r = row + dr
            shift = 0.5 * np.mod(r, 2)
            column = np.floor(along - shift) + dc
            x = along - shift - column - 0.5  # -1 .. 1 along the scale, free end at +
            y = across - r - 0.5
            # A leaf of length 2: rows overlap by half a scale.
            outline = np.clip(1 - np.abs(x) ** 2.4, 0, None) ** 0.75 * 0.98
            inside = np.abs(y) < outline
            dome = np.sqrt(np.clip(1 - (y / np.maximum(outline, 1e-6)) ** 2, 0, None))
            leaf = 0.42 + 0.34 * x + 0.30 * dome * (1 - 0.25 * x**2)
            height = np.where(inside, np.maximum(height, leaf), height)
    return height


def build(detail: float = 1.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The body's mesh.

    Parameters
    ----------
    detail
        1 gives about 700,000 faces.

    Returns
    -------
    points : ndarray
        ``(n, 3)`` metres.
    quads : ndarray
        ``(m, 4)`` indices.
    uv : ndarray
        ``(m, 4, 2)``: u runs along the body towards the neck, v around it.
    """
    fine = np.linspace(0, 1, 20001)
    line = centre_line(fine)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    # Lattice steps along the body keep the scales' shape where the body tapers.
    scale_size = 2 * np.pi * np.maximum(body_radius(fine), 0.02) / AROUND * 1.55
    lattice = np.concatenate([[0], np.cumsum(np.diff(length) / (0.5 * (scale_size[1:] + scale_size[:-1])))])
    rings = int(lattice[-1] * RINGS_A_SCALE * detail)
    sides = int(AROUND * SIDES_A_SCALE * detail)
    along = np.linspace(0, lattice[-1], rings)
    t = np.interp(along, lattice, fine)
    centre = np.stack([np.interp(t, fine, line[:, i]) for i in range(3)], -1)
    forward = np.gradient(centre, axis=0)
    forward /= np.linalg.norm(forward, axis=1, keepdims=True)
    side = np.cross(forward, (0.0, 0.0, 1.0))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, forward)

    angle = np.linspace(0, 2 * np.pi, sides + 1)
    radius = body_radius(t)
    # A free end points to the tail: the lattice runs against the body's direction.
    heights = scale_height(-along[:, None] + 0 * angle, angle[None] / (2 * np.pi) * AROUND + 0 * along[:, None])
    belly = np.clip(0.5 - 0.5 * np.sin(angle), 0, 1) ** 4  # smooth below, where nobody looks
    size = 2 * np.pi * radius / AROUND
    bump = (size[:, None] * 0.50) * heights * (1 - 0.7 * belly)
    profile = (radius[:, None] + bump)[..., None]
    # Slightly flattened, as a resting snake is.
    ring = np.cos(angle)[None, :, None] * side[:, None] * 1.06 + np.sin(angle)[None, :, None] * up[:, None] * 0.94
    points = centre[:, None] + profile * ring

    index = np.arange(rings)[:, None] * sides + (np.arange(sides + 1) % sides)[None]
    grid_uv = np.stack(np.broadcast_arrays((t * length[-1])[:, None], angle[None] / (2 * np.pi)), -1)

    def corners(array: np.ndarray) -> np.ndarray:
        return np.stack([array[:-1, :-1], array[1:, :-1], array[1:, 1:], array[:-1, 1:]], 2)

    quads = corners(index).reshape(-1, 4)
    uv = corners(grid_uv).reshape(-1, 4, 2)
    return points[:, :-1].reshape(-1, 3), quads, uv
