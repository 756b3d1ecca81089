# SPDX-License-Identifier: GPL-3.0-or-later
"""`windowed`: terms of a series on DFT bins, convolved with the transform of the coherence window.

With F_n the transform of term n of the patch and c_n(kappa) its weight (`precompute.bake.series`),

    P(f) = sum_n c_n(kappa) sum_(r,s) F_n(f_rs) phi(f - f_rs)
    phi(f) = 2 pi sigma_s^2 exp(-2 pi^2 sigma_s^2 |f|^2) df^2

which is eq. 3.26-3.32 of the thesis with the square *outside* of the sums and phi normalised. The sum over bins is a
sum over a periodic surface of the bins' period: untruncated, the patch is padded with zeros to twice its side or
more, so that the window sees one patch; it is then the single-window integral.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ...bake.window import check_sigma_s, gaussian_axis
from ...scan.heightfield import HeightField
from ..surface import coherence_area
from .bins import Band, axis_bins, make_terms, series_facts, weights_matrix

#: phi is followed to this many standard deviations: exp(-18) = 2e-8 of the peak.
_REACH = 6.0

#: Points evaluated at a time.
_BLOCK = 4096


class Windowed:
    """See the module. Points may lie anywhere in the band.

    Parameters
    ----------
    field
        A prepared heightfield.
    sigma_s_m
        Standard deviation of the coherence window in metres.
    series
        ``chebyshev`` or ``taylor``.
    tolerance
        Largest error of p that the series may leave.
    truncated
        The thesis's 3 x 3 neighbourhood on the bins of the patch itself, instead of the whole convolution.
    band
        Frequencies that will be asked for.
    dtype
        Of the stored terms.
    """

    def __init__(
        self,
        field: HeightField,
        sigma_s_m: float,
        series: str = "chebyshev",
        tolerance: float = 1e-6,
        truncated: bool = False,
        band: Band | None = None,
        dtype: type = np.complex128,
    ) -> None:
        self.field = field
        self.sigma_s_m = check_sigma_s(sigma_s_m)
        band = band or Band()
        rows, cols = field.shape
        sides = (rows * field.dy, cols * field.dx)
        #: Distances of the bins along y and x, 1/m.
        self.steps = tuple(1.0 / (side * (1 if truncated else self._padding(side))) for side in sides)
        width = 1.0 / (2.0 * np.pi * self.sigma_s_m)
        self.reach = (1, 1) if truncated else tuple(int(np.ceil(_REACH * width / step)) for step in self.steps)
        limits = (band.fy, band.fx)
        bins = [axis_bins(*axis) for axis in zip(self.steps, limits, (r + 1 for r in self.reach), strict=True)]
        self.first = tuple(int(j[0]) for j in bins)
        fy, fx = (j * step for j, step in zip(bins, self.steps, strict=True))
        self.series, self.terms = make_terms(field, series, tolerance, fy, fx, dtype)
        g = gaussian_axis(rows, field.dy, self.sigma_s_m), gaussian_axis(cols, field.dx, self.sigma_s_m)
        self.norm_m2 = float((g[0] @ g[0]) * (g[1] @ g[1])) * field.dx * field.dy
        self.area_m2 = coherence_area(field.shape, field.dx, field.dy, self.sigma_s_m, "single")
        self.facts: dict[str, Any] = {
            **series_facts(self.series, series, tolerance),
            "neighbours": (2 * self.reach[0] + 1) * (2 * self.reach[1] + 1),
        }

    def _padding(self, side_m: float) -> int:
        """Sides from patch to patch, so that the window at the edge of the next one is below exp(-18)."""
        return max(2, int(np.ceil(_REACH * self.sigma_s_m / side_m + 0.5)))

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray, wavelength_m: float) -> np.ndarray:
        """T_lambda in 1/sr for arrays (u, v, w) that broadcast."""
        u, v, w = np.broadcast_arrays(*(np.asarray(a, float) for a in (u, v, w)))
        kappa = 2.0 * np.pi / wavelength_m * np.abs(w)
        power = np.abs(self.amplitude(u.ravel() / wavelength_m, v.ravel() / wavelength_m, kappa.ravel())) ** 2
        return power.reshape(u.shape) / (self.norm_m2 * wavelength_m**2)

    def amplitude(self, fx: np.ndarray, fy: np.ndarray, kappa: np.ndarray) -> np.ndarray:
        """P in m^2 at points ``(m,)`` in 1/m."""
        result = np.empty(fx.shape, complex)
        terms = self.terms
        along_line = fy.size > 1 and np.ptp(fy) == 0.0
        if along_line:
            # All points share fy: its neighbours are summed once.
            index, phi = self._neighbours(fy[:1], 0)
            terms = np.einsum("k,nkx->nx", phi[0], terms[:, index[0]])
        for start in range(0, fx.size, _BLOCK):
            part = slice(start, start + _BLOCK)
            index_x, phi_x = self._neighbours(fx[part], 1)
            if along_line:
                convolved = np.einsum("nmk,mk->nm", terms[:, index_x], phi_x)
            else:
                index_y, phi_y = self._neighbours(fy[part], 0)
                convolved = np.zeros((len(terms), index_x.shape[0]), complex)
                for k in range(index_y.shape[1]):
                    row = np.einsum("nmk,mk->nm", terms[:, index_y[:, k, None], index_x], phi_x)
                    convolved += phi_y[:, k] * row
            result[part] = (weights_matrix(self.series, kappa[part]) * convolved).sum(axis=0)
        return result

    def _neighbours(self, frequency: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
        """``(m, k)`` indices into the terms and weights phi of the bins round each frequency, along y (0) or x (1)."""
        step, reach = self.steps[axis], self.reach[axis]
        bins = np.rint(frequency / step).astype(int)[:, None] + np.arange(-reach, reach + 1)
        away = frequency[:, None] - bins * step
        phi = np.sqrt(2.0 * np.pi) * self.sigma_s_m * step * np.exp(-2.0 * (np.pi * self.sigma_s_m * away) ** 2)
        return bins - self.first[axis], phi
