# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothed intensity S(f; kappa) = lambda^2 T on a polar grid of spatial frequencies.

All ensembles are one formula: with the autocorrelation ``R(D)`` of ``p`` times a window,

    lambda^2 T = 1 / norm * integral R(D) m(D) exp(2 pi i f.D) dD,   f = (u, v) / lambda

* ``average``: the window is the Tukey taper t, ``m = exp(-|D|^2 / (4 sigma_s^2))``, norm = integral t^2;
* ``single``: the window is the Gaussian g in the middle of the patch, ``m = 1``, norm = integral g^2
  (then the integral is |P|^2);
* ``periodic``: the same with a window of 1 over all copies of the patch, norm = their area.

Three things keep it cheap. Frequencies above 2 / lambda_min are never seen, so the spectrum
is cropped to that band before anything else. ``m`` (or the window itself) ends the lags after
a few sigma_s, so the last transform is small. And the cubic B-spline that reads the polar grid
off the Cartesian one has its prefilter in the lag domain, where it is one multiplication, and
its 16 weights a point are computed once for all kappa.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..constants import FREQUENCY_MAX, KAPPA_MAX
from ..scan.heightfield import HeightField
from ..scipy_kernels import sparse_product
from .series import Series
from .spectral_sum import RADIAL_STEP
from .transforms import Axis, Transforms, interleave, lobe_width, workers
from .window import window_axis

#: Intensities of single kappas that are kept apart before they are put side by side.
PLANES = 4


class PolarIntensity:
    """Computes S(f; kappa) of a patch on a polar frequency grid.

    Parameters
    ----------
    field
        A prepared patch (levelled, filled, pixels at most lambda_min / 4).
    sigma_s_m
        Coherence window, metres.
    ensemble
        ``average``, ``single`` or ``periodic``.
    series, tolerance, kappa_max
        See :class:`precompute.bake.series.Series`.

    Attributes
    ----------
    frequencies : ndarray
        ``(n_f,)`` radial frequencies from 0 to beyond 2 / lambda_min, 1/m, evenly spaced.
    x, y : Axis
        Lengths and steps of the transforms.
    window_axes, lag_axes : tuple of ndarray
        Factors along y and x of the window and of what the lags are multiplied by, the B-spline's prefilter included.
    """

    def __init__(
        self,
        field: HeightField,
        sigma_s_m: float,
        ensemble: str,
        series: str = "nodes",
        tolerance: float = 1e-4,
        kappa_max: float = KAPPA_MAX,
        frequency_max: float = FREQUENCY_MAX,
    ) -> None:
        rows, cols = field.shape
        smoothed = ensemble == "average"
        self.window_axes = (
            window_axis(rows, field.dy, sigma_s_m, ensemble),
            window_axis(cols, field.dx, sigma_s_m, ensemble),
        )
        # Lags without weights may not wrap around: what ends at the cut is as bright as what lies within.
        windows = self.window_axes if smoothed else (None, None)
        self.y = Axis.plan(rows, field.dy, sigma_s_m, frequency_max, windows[0], smoothed)
        self.x = Axis.plan(cols, field.dx, sigma_s_m, frequency_max, windows[1], smoothed)
        area = float(np.prod([axis @ axis for axis in self.window_axes])) * field.dx * field.dy
        # One transform a kappa multiplies the rows by the window as it goes; a series needs it whole.
        window = np.ones((1, 1)) if series == "nodes" else np.outer(*self.window_axes)
        self.series = Series(field.heights, window, kappa_max, series, tolerance, self._spectrum)
        self.lag_axes = self._make_lag_axes(sigma_s_m if smoothed else None)
        self._transforms = Transforms(self.x, self.y, self.lag_axes)
        # |sum p|^2 (dx dy)^2 / norm; the inverse transform over the band divides by its size and multiplies
        # by the lag area of 1 / (padded steps), the last transform integrates over lags.
        pixel = field.dx * field.dy
        self._factor = pixel**2 / area / (self.x.padded * self.y.padded * pixel) * self.x.lag_step * self.y.lag_step
        step = RADIAL_STEP * lobe_width(sigma_s_m)
        count = int(np.ceil(frequency_max / step)) + 4
        self.frequencies = step * np.arange(count)

    def _spectrum(self, p: np.ndarray) -> np.ndarray:
        """sum p exp(+2 pi i f.x) over the pixels, on the band, of a term of a series."""

        def rows(here: slice, out: np.ndarray) -> None:
            out[...] = p[here]

        with ThreadPoolExecutor(workers()) as pool:
            return self._transforms.spectrum(self._transforms.band(rows, p.dtype, pool), pool)

    def _make_lag_axes(self, sigma_s_m: float | None) -> tuple[np.ndarray, np.ndarray]:
        """``(fine_y,)`` and ``(fine_x,)``: lag window times the B-spline's prefilter, with the cut lags zero."""
        weights = []
        for axis in (self.y, self.x):
            index = np.fft.fftfreq(axis.fine, 1.0 / axis.fine)
            # A cubic B-spline multiplies the lag domain by sinc^4(D / period): undo that.
            weight = np.sinc(index / axis.fine) ** -4
            if sigma_s_m is not None:
                weight *= np.exp(-((index * axis.lag_step) ** 2) / (4.0 * sigma_s_m**2))
            weight[np.abs(index) > axis.cut] = 0.0
            weights.append(weight)
        return weights[0], weights[1]

    def coefficients(self, kappas: np.ndarray, progress: Callable[[float], None] | None = None) -> np.ndarray:
        """B-spline coefficients of S on the fine Cartesian grid, for every kappa.

        Parameters
        ----------
        kappas
            ``(n,)``, 1/m.
        progress
            Called with the fraction done.

        Returns
        -------
        ndarray
            ``(fine_y * fine_x, n)`` float32, frequency zero in the middle.
        """
        count = len(kappas)
        out = np.empty((self.y.fine, self.x.fine, count), np.float32)
        spectra = None if self.series.method == "nodes" else self.series.amplitudes(kappas)
        # Single kappas would write one number to each line of the cache: some are collected first.
        planes = np.empty((min(PLANES, count), self.y.fine, self.x.fine), np.float32)
        with ThreadPoolExecutor(workers()) as pool:
            for start in range(0, count, PLANES):
                group = range(start, min(start + PLANES, count))
                for plane, index in zip(planes, group, strict=False):
                    if spectra is None:
                        self._of_node(kappas[index], plane, pool)
                    else:
                        self._transforms.of_spectrum(next(spectra), plane, pool)
                    if progress is not None:
                        progress((index + 1) / count)
                interleave(planes[: len(group)], out[..., group.start : group.stop], pool)
        self._transforms.free()
        return out.reshape(-1, count)

    def _of_node(self, kappa: float, out: np.ndarray, pool: ThreadPoolExecutor) -> None:
        along_y, along_x = (axis.astype(np.float32) for axis in self.window_axes)

        def rows(here: slice, lines: np.ndarray) -> None:
            self.series.rows(kappa, here, along_y[here, None] * along_x, lines)

        self._transforms.of_band(self._transforms.band(rows, np.complex64, pool), out, pool)

    def polar(
        self,
        coefficients: np.ndarray,
        angles: np.ndarray,
        frequencies: np.ndarray | None = None,
        opposite: bool = False,
    ) -> np.ndarray:
        """S on the polar grid.

        Parameters
        ----------
        coefficients
            From :meth:`coefficients`.
        angles
            ``(m,)`` radians.
        frequencies
            ``(n_f,)`` radial, 1/m; all for None.
        opposite
            Whether the same angles half a circle on follow them, which have the same weights.

        Returns
        -------
        ndarray
            ``(m, n_f, n)`` float32, m^2; ``(2 m, n_f, n)`` with the opposite ones.
        """
        frequencies = self.frequencies if frequencies is None else frequencies
        row, wy = _cubic_b_spline(np.outer(np.sin(angles), frequencies / self.y.frequency_step).ravel())
        col, wx = _cubic_b_spline(np.outer(np.cos(angles), frequencies / self.x.frequency_step).ravel())
        wy *= np.float32(self._factor)
        # Neighbours along a ray share most of their cells: angle by angle.
        weights = (wy[:, :, None] * wx[:, None, :]).reshape(-1, 16)
        values = np.empty((1 + opposite, len(weights), coefficients.shape[1]), np.float32)
        for turned, target in enumerate(values):
            y = (self.y.fine // 2 + (-row if turned else row)) % self.y.fine * np.int32(self.x.fine)
            x = (self.x.fine // 2 + (-col if turned else col)) % self.x.fine
            indices = (y[:, :, None] + x[:, None, :]).reshape(-1, 16)
            sparse_product(indices, weights, coefficients, out=target)
        np.maximum(values, 0.0, out=values)
        return values.reshape(-1, len(frequencies), coefficients.shape[1])


def _cubic_b_spline(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Four indices (int32) and weights (float32) of the cubic B-spline at each position; shape ``(..., 4)``."""
    first = np.floor(position)
    t = (position - first).astype(np.float32)
    u = np.float32(1.0) - t
    weights = np.stack([u**3, 4 - 6 * t**2 + 3 * t**3, 4 - 6 * u**2 + 3 * u**3, t**3], axis=-1)
    weights *= np.float32(1.0 / 6.0)
    return first.astype(np.int32)[..., None] + np.arange(-1, 3, dtype=np.int32), weights
