# SPDX-License-Identifier: GPL-3.0-or-later
"""`pq`: a periodic surface of N1 x N2 copies of the patch, lit coherently as a whole.

The copies multiply |P|^2 of one period by ``sin^2(N a / 2) / sin^2(a / 2)``, ``a = k u T`` along x and the same with
v along y (eq. 3.33-3.48 of the thesis with N + 1 written as N, the number of copies); the limit is N^2 at a = 2 pi m.
Between the DFT bins of the period P is interpolated by the periodic sinc, which is exact: the patch is zero outside
of one period and its transform is a trigonometric polynomial (eq. 3.49 has the sinc of the continuous case).
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...errors import ParameterError, ScanError
from ...scan.heightfield import HeightField
from .bins import make_terms, series_facts, weights_matrix

_BLOCK = 2048


def periodic_sinc(x: np.ndarray, count: int) -> np.ndarray:
    """``sin(pi count x) / (count sin(pi x))`` without a division by zero; its modulus is 1 at whole x."""
    whole = np.rint(x)
    rest = x - whole
    value = np.sinc(count * rest) / np.sinc(rest)
    return np.where((whole * (count - 1)) % 2 == 0, value, -value)


def replica_factor(phase: np.ndarray, count: int) -> np.ndarray:
    """``sin^2(count a / 2) / sin^2(a / 2)`` for phases a in radians; count^2 at multiples of 2 pi."""
    return (count * periodic_sinc(np.asarray(phase, float) / (2.0 * np.pi), count)) ** 2


class Periodic:
    """See the module.

    Parameters
    ----------
    field
        One period of the surface, prepared.
    replicas
        Copies along x and along y.
    series, tolerance
        As in `precompute.evaluate.methods.windowed.Windowed`.
    """

    def __init__(
        self, field: HeightField, replicas: tuple[int, int], series: str = "chebyshev", tolerance: float = 1e-6
    ) -> None:
        self.replicas = (int(replicas[0]), int(replicas[1]))
        if min(self.replicas) < 1:
            raise ParameterError(f"{self.replicas[0]} x {self.replicas[1]} copies make no surface; give at least 1.")
        if field.missing.any():
            raise ScanError("The scan has missing heights; fill them before its BRDF is evaluated.")
        self.field = field
        rows, cols = field.shape
        self.fy, self.fx = np.fft.fftfreq(rows, field.dy), np.fft.fftfreq(cols, field.dx)
        self.series, self.terms = make_terms(field, series, tolerance, self.fy, self.fx)
        #: The lit area, m^2.
        self.norm_m2 = field.size_m[0] * field.size_m[1] * self.replicas[0] * self.replicas[1]
        self.area_m2 = self.norm_m2
        self.facts: dict[str, Any] = {**series_facts(self.series, series, tolerance), "replicas": list(self.replicas)}

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray, wavelength_m: float) -> np.ndarray:
        """T_lambda in 1/sr for arrays (u, v, w) that broadcast."""
        u, v, w = np.broadcast_arrays(*(np.asarray(a, float) for a in (u, v, w)))
        k = 2.0 * np.pi / wavelength_m
        tile = self.amplitude(u.ravel() / wavelength_m, v.ravel() / wavelength_m, k * np.abs(w).ravel())
        power = np.abs(tile.reshape(u.shape)) ** 2
        for component, side, count in zip((u, v), self.field.size_m, self.replicas, strict=True):
            power = power * replica_factor(k * component * side, count)
        return power / (self.norm_m2 * wavelength_m**2)

    def amplitude(self, fx: np.ndarray, fy: np.ndarray, kappa: np.ndarray) -> np.ndarray:
        """P of one period in m^2 at points ``(m,)`` in 1/m."""
        rows, cols = self.field.shape
        result = np.empty(fx.shape, complex)
        terms = self.terms
        along_line = fy.size > 1 and np.ptp(fy) == 0.0
        if along_line:
            terms = np.einsum("r,nrc->nc", periodic_sinc((fy[0] - self.fy) * self.field.dy, rows), terms)
        for start in range(0, fx.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            across = periodic_sinc((fx[part, None] - self.fx) * self.field.dx, cols)
            if along_line:
                value = terms @ across.T
            else:
                up = periodic_sinc((fy[part, None] - self.fy) * self.field.dy, rows)
                value = np.stack([np.einsum("mr,mr->m", up, across @ term.T) for term in terms])
            result[part] = (weights_matrix(self.series, kappa[part]) * value).sum(axis=0)
        return result
