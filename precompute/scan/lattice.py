# SPDX-License-Identifier: GPL-3.0-or-later
"""The lattice of a surface: its dominant periods, found in the power spectrum."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .heightfield import HeightField
from .levelling import level
from .missing import fill_missing

#: A peak stands this far above the largest value on a circle round it, or it is none.
_MIN_CONTRAST = 1.75
_CIRCLE = 0.4
#: Fewest periods of a peak across the patch.
_MIN_PERIODS = 4.0
#: Two vectors span a lattice when the sine of the angle between them is larger.
_MIN_SINE = 0.25


@dataclass(frozen=True)
class Lattice:
    """Dominant periods of a surface.

    Parameters
    ----------
    frequencies
        ``(n, 2)`` wave vectors (fx, fy) in 1/m without the factor 2 pi, strongest first, n = 0, 1 or 2.
    contrasts
        How far each peak stands above its surroundings, at least 1.75.
    """

    frequencies: np.ndarray
    contrasts: np.ndarray

    @property
    def spacings_m(self) -> np.ndarray:
        """Distances of the lattice planes, ``1 / |f|``, in metres."""
        return 1.0 / np.hypot(self.frequencies[:, 0], self.frequencies[:, 1])

    @property
    def vectors_m(self) -> np.ndarray:
        """``(n, 2)`` lattice vectors in metres, ``a_i . f_j = delta_ij``; the shortest such vector for n = 1."""
        return np.linalg.pinv(self.frequencies).T if len(self.frequencies) else np.zeros((0, 2))


def power_spectrum(field: HeightField) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Power spectrum of the levelled heights under a Hann window.

    Returns
    -------
    tuple
        ``(rows, cols)`` power in m^2, normalised so that its sum is the variance of the heights, with
        the zero frequency in the middle; and the frequencies fx ``(cols,)`` and fy ``(rows,)`` in 1/m.
    """
    from scipy.fft import fft2, fftfreq, fftshift

    field = fill_missing(level(field, "poly2"))
    rows, cols = field.shape
    window = np.outer(_hann(rows), _hann(cols))
    power = np.abs(fftshift(fft2(field.heights * window, workers=-1))) ** 2
    total = power.sum()
    if total > 0.0:
        power *= field.heights.var() / total
    return power, fftshift(fftfreq(cols, field.dx)), fftshift(fftfreq(rows, field.dy))


def find_lattice(field: HeightField) -> Lattice:
    """Up to two independent dominant wave vectors of a surface.

    The power spectrum times f (so that long waves do not win, and harmonics neither) is
    smoothed over two bins; its maxima are candidates. The exact place is the centroid of the power
    round the maximum: for a single line under a Hann window the centroid is the line's frequency to
    a small part of a bin, and for the broad peaks of a disordered structure it is the mean.

    Parameters
    ----------
    field
        The heightfield; levelled inside.

    Returns
    -------
    Lattice
        With fewer than two vectors where the surface has no second or no period.
    """
    from scipy.ndimage import gaussian_filter

    power, fx, fy = power_spectrum(field)
    step_x, step_y = 1.0 / field.size_m[0], 1.0 / field.size_m[1]
    radius = np.hypot(fx[None, :], fy[:, None])
    slopes = gaussian_filter(power * radius, 2.0, mode="wrap")
    allowed = radius > _MIN_PERIODS * max(step_x, step_y)
    # Beyond half the Nyquist frequency noise times f^2 would win.
    allowed &= radius < 0.5 * min(np.abs(fx).max(), np.abs(fy).max())
    allowed &= (fy[:, None] > 0.0) | ((fy[:, None] == 0.0) & (fx[None, :] > 0.0))
    candidates = np.where(allowed, slopes, 0.0)
    noise = 1e-9 * float(slopes.max()) + np.finfo(float).tiny

    found: list[tuple[float, float]] = []
    contrasts: list[float] = []
    for _ in range(16):
        row, col = np.unravel_index(np.argmax(candidates), candidates.shape)
        if candidates[row, col] <= noise:
            break
        fx0, fy0 = float(fx[col]), float(fy[row])
        size = float(np.hypot(fx0, fy0))
        contrast = candidates[row, col] / max(_on_circle(slopes, fx, fy, fx0, fy0, _CIRCLE * size), noise)
        near = np.hypot(fx[None, :] - fx0, fy[:, None] - fy0) < _CIRCLE * size
        candidates = np.where(near, 0.0, candidates)
        if contrast < _MIN_CONTRAST:
            continue
        vector = _centroid(power, fx, fy, fx0, fy0, max(0.2 * size, 4.0 * max(step_x, step_y)))
        found.append(vector)
        contrasts.append(float(contrast))
        sines = np.abs(fx[None, :] * vector[1] - fy[:, None] * vector[0])
        independent = sines > _MIN_SINE * np.hypot(*vector) * np.maximum(radius, np.finfo(float).tiny)
        candidates = np.where(independent, candidates, 0.0)
        if len(found) == 2:
            break
    return Lattice(np.array(found).reshape(-1, 2), np.array(contrasts))


def _hann(count: int) -> np.ndarray:
    return 0.5 - 0.5 * np.cos(2.0 * np.pi * (np.arange(count) + 0.5) / count)


def _on_circle(values: np.ndarray, fx: np.ndarray, fy: np.ndarray, fx0: float, fy0: float, radius: float) -> float:
    """Largest value on a circle round a point."""
    angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
    cols = np.rint((fx0 + radius * np.cos(angles) - fx[0]) / (fx[1] - fx[0])).astype(int) % fx.size
    rows = np.rint((fy0 + radius * np.sin(angles) - fy[0]) / (fy[1] - fy[0])).astype(int) % fy.size
    return float(values[rows, cols].max())


def _centroid(
    power: np.ndarray, fx: np.ndarray, fy: np.ndarray, fx0: float, fy0: float, radius: float
) -> tuple[float, float]:
    """Mean frequency of the power within ``radius``, moved along until it stays."""
    for _ in range(20):
        cols, rows = np.abs(fx - fx0) <= radius, np.abs(fy - fy0) <= radius
        part = power[np.ix_(rows, cols)]
        part = part * (np.hypot(fx[cols][None, :] - fx0, fy[rows][:, None] - fy0) <= radius)
        total = part.sum()
        new_x, new_y = float((part * fx[cols][None, :]).sum() / total), float((part * fy[rows][:, None]).sum() / total)
        moved = np.hypot(new_x - fx0, new_y - fy0)
        fx0, fy0 = new_x, new_y
        if moved < 1e-6 * radius:
            break
    return fx0, fy0
