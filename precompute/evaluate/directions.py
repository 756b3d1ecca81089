# SPDX-License-Identifier: GPL-3.0-or-later
"""Directions by angles and as vectors, and the coordinates (u, v, w) of the transform."""

from __future__ import annotations

import numpy as np


def from_angles(theta: np.ndarray | float, phi: np.ndarray | float) -> np.ndarray:
    """Unit vectors ``(..., 3)`` of polar angles ``theta`` from the normal and azimuths ``phi`` from the tangent.

    Both in radians; a negative ``theta`` lies on the opposite side of the normal.
    """
    theta, phi = np.broadcast_arrays(np.asarray(theta, float), np.asarray(phi, float))
    sin = np.sin(theta)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), np.cos(theta)], axis=-1)


def to_angles(direction: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Polar angle in [0, pi] and azimuth in (-pi, pi], radians, of vectors ``(..., 3)`` of any length."""
    x, y, z = np.moveaxis(np.asarray(direction, float), -1, 0)
    return np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)


def uvw(wi: np.ndarray, wr: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """``(u, v, w) = -(wi + wr)`` of unit vectors ``(..., 3)`` towards the light and the viewer."""
    total = -(np.asarray(wi, float) + np.asarray(wr, float))
    return total[..., 0], total[..., 1], total[..., 2]


def disc_directions(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions of an orthographic picture of the hemisphere.

    Parameters
    ----------
    size
        Pixels along each side.

    Returns
    -------
    directions : ndarray
        ``(size, size, 3)`` unit vectors at pixel centres, row 0 at the *bottom*: x to the right, y up, from
        -1 to 1 across the picture. The normal where ``inside`` is False.
    inside : ndarray
        ``(size, size)`` bool, True within the unit disc.
    """
    axis = (np.arange(size) + 0.5) * (2.0 / size) - 1.0
    x, y = np.meshgrid(axis, axis)
    squared = x**2 + y**2
    inside = squared < 1.0
    z = np.sqrt(np.where(inside, 1.0 - squared, 1.0))
    return np.stack([np.where(inside, x, 0.0), np.where(inside, y, 0.0), z], axis=-1), inside
