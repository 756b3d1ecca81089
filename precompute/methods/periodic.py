# SPDX-License-Identifier: GPL-3.0-or-later
"""Periodic surface: copies of one patch, the thesis's factors p and q (eq. 3.33-3.48)."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..heightfield import HeightField
from .amplitude import Amplitude


def array_factor(phase: np.ndarray, count: int) -> np.ndarray:
    """``|sum_(n < count) exp(i n a)|^2 = sin^2(count a / 2) / sin^2(a / 2)``, the thesis's p^2 + q^2.

    Parameters
    ----------
    phase
        a, radians.
    count
        Number of copies (the thesis's N + 1).

    Returns
    -------
    ndarray
        ``count^2`` at a = 2 pi m, by its limit.
    """
    # Sine ratios depend on the distance to the nearest peak only; near it the quotient is 0 / 0.
    half = 0.5 * np.asarray(phase, float)
    half = half - np.pi * np.rint(half / np.pi)
    peak = np.abs(half) < 1e-7 / count
    safe = np.where(peak, 1.0, half)
    return np.where(peak, float(count) ** 2, (np.sin(count * safe) / np.sin(safe)) ** 2)


class Periodic:
    """``replicas`` copies of a patch that is one period.

    ``|P|^2 = |P_patch|^2 F(k u T_x, N_x) F(k v T_y, N_y)`` with :func:`array_factor` F and P of the patch
    alone between the bins by sinc interpolation (eq. 3.49).

    Parameters
    ----------
    field
        A prepared patch, one period along x and y.
    replicas
        Copies along x and y.
    series, tolerance
        Series of p and the largest error it may leave.
    """

    def __init__(self, field: HeightField, replicas: tuple[int, int], series: str, tolerance: float) -> None:
        if len(replicas) != 2 or any(int(n) != n or n < 1 for n in replicas):
            raise ParameterError(f"The replicas are {replicas}; give two whole numbers of at least 1.")
        self.replicas = (int(replicas[0]), int(replicas[1]))
        self._amplitude = Amplitude(field, np.ones(field.shape), series, tolerance)
        self._period = field.size_m
        self._count = float(field.heights.size) * self.replicas[0] * self.replicas[1]
        self.terms = self._amplitude.terms
        self.absolute_scale = self._count * field.dx * field.dy

    def power(self, u: np.ndarray, v: np.ndarray, w: np.ndarray, wavelength_m: np.ndarray) -> np.ndarray:
        """``|P|^2 / N^2``; see :class:`precompute.methods.Method`."""
        u, v, w = (np.asarray(x, float) for x in (u, v, w))
        k = 2.0 * np.pi / np.asarray(wavelength_m, float)
        amplitude = self._amplitude(u / wavelength_m, v / wavelength_m, k * np.abs(w))
        factor = array_factor(k * u * self._period[0], self.replicas[0])
        factor = factor * array_factor(k * v * self._period[1], self.replicas[1])
        return np.abs(amplitude) ** 2 * factor / self._count**2
