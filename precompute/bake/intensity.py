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

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..constants import FREQUENCY_MAX, KAPPA_MAX
from ..scan.heightfield import HeightField
from .series import Series
from .window import window_axis

#: Lags beyond this many sigma_s are cut: exp(-6.5^2 / 4) = 2.6e-5.
LAG_CUT = 6.5

#: Side of the lag square that the last transform sees, in cut lags: room for the B-spline.
LAG_ROOM = 1.2

#: Frequencies kept beyond the visible band, in widths of the coherence lobe.
BAND_MARGIN = 6.0

#: Radial step of the polar grid in widths s_f of the coherence lobe (cubic interpolation in between).
RADIAL_STEP = 0.4


def lobe_width(sigma_s_m: float) -> float:
    """Standard deviation s_f = 1 / (2 pi sqrt(2) sigma_s) of the intensity's lobe in spatial frequency (1/m)."""
    return 1.0 / (2.0 * np.pi * np.sqrt(2.0) * sigma_s_m)


def workers() -> int:
    """Threads for transforms: all processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@dataclass(frozen=True)
class Axis:
    """One axis of the transforms: from pixels to cropped frequencies, lags and fine frequencies."""

    pixels: int
    step: float  # pixel size, m
    padded: int  # length of the first transform
    band: int  # frequencies kept (even)
    cut: int  # lags kept on either side
    fine: int  # length of the last transform

    @classmethod
    def plan(cls, pixels: int, step: float, sigma_s_m: float) -> Axis:
        from scipy.fft import next_fast_len

        length = pixels * step
        lag_cut = min(length, LAG_CUT * sigma_s_m)
        padded = next_fast_len(int(np.ceil((length + lag_cut) / step)) + 1)
        top = FREQUENCY_MAX + BAND_MARGIN * lobe_width(sigma_s_m)
        # Even and of small prime factors.
        band = 2 * next_fast_len(int(np.ceil(top * padded * step)) + 1, real=True)
        lag_step = padded * step / band
        cut = min(int(np.ceil(lag_cut / lag_step)), band // 2 - 1)
        fine = 2 * next_fast_len(int(np.ceil(LAG_ROOM * cut)) + 4, real=True)
        return cls(pixels, step, padded, band, cut, fine)

    @property
    def lag_step(self) -> float:
        return self.padded * self.step / self.band

    @property
    def frequency_step(self) -> float:
        """Step of the fine frequency grid, 1/m."""
        return 1.0 / (self.fine * self.lag_step)

    def band_indices(self) -> np.ndarray:
        """Indices into the padded transform, which is periodic, in FFT order of the band."""
        return np.fft.fftfreq(self.band, 1.0 / self.band).astype(int) % self.padded


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
    ) -> None:
        rows, cols = field.shape
        self.x = Axis.plan(cols, field.dx, sigma_s_m)
        self.y = Axis.plan(rows, field.dy, sigma_s_m)
        self.window_axes = (
            window_axis(rows, field.dy, sigma_s_m, ensemble),
            window_axis(cols, field.dx, sigma_s_m, ensemble),
        )
        window = np.outer(*self.window_axes)
        area = float(np.sum(window * window)) * field.dx * field.dy
        self.series = Series(field.heights, window, kappa_max, series, tolerance, self._spectrum)
        self.lag_axes = self._make_lag_axes(sigma_s_m if ensemble == "average" else None)
        self._lag_weight = np.outer(self.lag_axes[0], self.lag_axes[1][: self.x.fine // 2 + 1]).astype(np.float32)
        # |sum p|^2 (dx dy)^2 / norm; the inverse transform over the band divides by its size and multiplies
        # by the lag area of 1 / (padded steps), the last transform integrates over lags.
        pixel = field.dx * field.dy
        self._factor = pixel**2 / area / (self.x.padded * self.y.padded * pixel) * self.x.lag_step * self.y.lag_step
        step = RADIAL_STEP * lobe_width(sigma_s_m)
        count = int(np.ceil(FREQUENCY_MAX / step)) + 4
        self.frequencies = step * np.arange(count)

    def _spectrum(self, p: np.ndarray) -> np.ndarray:
        """sum p exp(+2 pi i f.x) over the pixels, on the band. Rows first, so that padding costs little."""
        from scipy.fft import ifft

        threads = workers()
        along_x = ifft(p, self.x.padded, axis=1, norm="forward", workers=threads)
        along_x = np.take(along_x, self.x.band_indices(), axis=1)
        along_y = ifft(along_x, self.y.padded, axis=0, norm="forward", workers=threads, overwrite_x=True)
        return np.take(along_y, self.y.band_indices(), axis=0)

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
        out = np.empty((self.y.fine * self.x.fine, len(kappas)), np.float32)
        for index, spectrum in enumerate(self.series.amplitudes(kappas)):
            out[:, index] = self._smoothed(spectrum).ravel()
            if progress is not None:
                progress((index + 1) / len(kappas))
        return out

    def _smoothed(self, spectrum: np.ndarray) -> np.ndarray:
        from scipy.fft import irfft2, rfft2

        threads = workers()
        power = np.square(spectrum.real, dtype=np.float32)
        power += np.square(spectrum.imag, dtype=np.float32)
        # R at the lags of the band; power is real, so half a plane holds them all.
        lags = rfft2(power, workers=threads, overwrite_x=True)
        cut_y, cut_x = self.y.cut, self.x.cut
        small = np.zeros((self.y.fine, self.x.fine // 2 + 1), lags.dtype)
        small[: cut_y + 1, : cut_x + 1] = lags[: cut_y + 1, : cut_x + 1]
        small[-cut_y:, : cut_x + 1] = lags[-cut_y:, : cut_x + 1]
        small *= self._lag_weight
        # rfft2 gave sum power exp(-2 pi i f.D), so irfft2 with exp(+2 pi i f.D) returns to +f.
        fine = irfft2(small, (self.y.fine, self.x.fine), norm="forward", workers=threads, overwrite_x=True)
        return np.fft.fftshift(fine)

    def polar(self, coefficients: np.ndarray, angles: np.ndarray) -> np.ndarray:
        """S on the polar grid.

        Parameters
        ----------
        coefficients
            From :meth:`coefficients`.
        angles
            ``(m,)`` radians.

        Returns
        -------
        ndarray
            ``(n_f, n, m)`` float32, m^2.
        """
        from scipy.sparse import csr_array

        row, wy = _cubic_b_spline(np.outer(self.frequencies / self.y.frequency_step, np.sin(angles)).ravel())
        col, wx = _cubic_b_spline(np.outer(self.frequencies / self.x.frequency_step, np.cos(angles)).ravel())
        row = (row + self.y.fine // 2) % self.y.fine
        col = (col + self.x.fine // 2) % self.x.fine
        weights = (np.float32(self._factor) * wy[:, :, None] * wx[:, None, :]).reshape(-1)
        indices = (row[:, :, None] * np.int32(self.x.fine) + col[:, None, :]).reshape(-1)
        pointers = np.arange(0, len(weights) + 1, 16)
        matrix = csr_array((weights, indices, pointers), shape=(len(row), len(coefficients)))
        values = (matrix @ coefficients).reshape(len(self.frequencies), len(angles), -1)
        return np.maximum(values.transpose(0, 2, 1), 0.0)


def _cubic_b_spline(position: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Four indices (int32) and weights (float32) of the cubic B-spline at each position; shape ``(..., 4)``."""
    first = np.floor(position)
    t = (position - first).astype(np.float32)
    u = np.float32(1.0) - t
    weights = np.stack([u**3, 4 - 6 * t**2 + 3 * t**3, 4 - 6 * u**2 + 3 * u**3, t**3], axis=-1)
    weights *= np.float32(1.0 / 6.0)
    return first.astype(np.int32)[..., None] + np.arange(-1, 3, dtype=np.int32), weights
