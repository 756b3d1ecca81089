# SPDX-License-Identifier: GPL-3.0-or-later
"""From intensities at nodes of kappa to XYZ slices: the integral over wavelength as matrix products.

For a slice |w| and a radius r, wavelength lambda looks at the frequency ``f = r / lambda`` and at
``kappa = 2 pi |w| / lambda``. Both the interpolation in kappa (polynomial through the nodes) and in
f (cubic Lagrange) are linear, so everything between the intensities S and the texels of one radius
is one matrix

    M[(w, c), (f, n)] = sum_lambda weight_c(lambda) / lambda^2  L_n(2 pi |w| / lambda)  C_f(r / lambda)

and the integral is ``M @ S``; no array is resampled. Far from the peak the light's spectrum smears over many
frequencies and every second one of them says it all: where that is so is found out from the light (`coarse_from`).
What depends on the wavelength, the radius and the slice alone goes into the same matrix: the reflectance of a stack,
``R(lambda, theta_half)`` with ``cos(theta_half) = |(u, v, w)| / (2 n) = min(1, sqrt(r^2 + w^2) / (2 n))``, and the cap
of the energy.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy

import numpy as np

from ..scipy_kernels import spread_product
from ..stack import Material, Stack
from .series import node_weights
from .transforms import LAG_CUT, lobe_width, workers

#: Radial step of the intensities in widths s_f of the coherence lobe (cubic interpolation in between).
RADIAL_STEP = 0.4

#: Largest error that a step twice as wide may leave in any lag of the intensities, relative to the whole light.
_COARSE_ERROR = 5e-4

#: Radii whose matrices a thread makes at a time.
_RADII_A_TIME = 8


class Reflectance:
    """R(lambda, theta_half) of a stack as the table's coordinates see it.

    Parameters
    ----------
    stack
        Films and substrate.
    wavelengths
        ``(L,)`` metres.
    lacquer, index
        What lies over it, and its refractive index for directions.
    """

    def __init__(self, stack: Stack, wavelengths: np.ndarray, lacquer: Material | None, index: float) -> None:
        cosines, sampled = stack.sampled(wavelengths, lacquer)
        self._steps = len(cosines) - 1
        self._sampled = np.ascontiguousarray(sampled.T)
        self._index = index

    def __call__(self, r: float, slices: np.ndarray) -> np.ndarray:
        """``(n_w, L)`` at a radius and all slices."""
        return self.at(np.sqrt(r**2 + slices**2) / (2.0 * self._index))

    def thinned(self, every: int) -> Reflectance:
        """The same at every so many of its wavelengths."""
        fewer = copy(self)
        fewer._sampled = np.ascontiguousarray(self._sampled[:, ::every])
        return fewer

    def at(self, cosines: np.ndarray) -> np.ndarray:
        """``(..., L)`` at cosines in front of the stack."""
        place = np.clip(cosines, 0.0, 1.0) * self._steps
        lower = np.minimum(place.astype(int), self._steps - 1)
        part = (place - lower)[..., None]
        return self._sampled[lower] * (1.0 - part) + self._sampled[lower + 1] * part


def cubic_lagrange(position: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """First index and ``(..., 4)`` weights of cubic Lagrange interpolation at ``position`` on 0 ... count-1."""
    first = np.clip(np.floor(position).astype(int) - 1, 0, count - 4)
    t = position - first
    weights = np.stack(
        [
            -(t - 1) * (t - 2) * (t - 3) / 6,
            t * (t - 2) * (t - 3) / 2,
            -t * (t - 1) * (t - 3) / 2,
            t * (t - 1) * (t - 2) / 6,
        ],
        axis=-1,
    )
    return first, weights


class SpectralSum:
    """The integral over wavelength, prepared for one table and applied to blocks of angles.

    Parameters
    ----------
    frequencies
        ``(n_f,)`` radial frequencies of the intensities, evenly spaced from 0 by `RADIAL_STEP`, 1/m.
    nodes, kappa_max
        Chebyshev nodes of the intensities and the end of their interval, 1/m.
    radii
        ``(n_r,)`` radii sqrt(u^2 + v^2).
    slices
        ``(n_w,)`` values of |w|.
    wavelengths, weights
        ``(L,)`` metres and ``(L, 3)`` from :func:`precompute.light.colour.spectral_weights`.
    progress
        Called with the fraction of the matrices that are made.
    reflectance
        Of the surface's stuff; None is R = 1.
    gain
        ``(n_w, L)`` a further factor, see `precompute.bake.energy`; None is 1.
    coarse
        First radius that uses every second frequency; None asks `coarse_from`.

    Attributes
    ----------
    grids : list of ndarray
        Frequencies at which `apply` wants the intensities: those near the peak, and every second one of all, if any.
    coarse : int
        As given or found.
    """

    def __init__(
        self,
        frequencies: np.ndarray,
        nodes: np.ndarray,
        kappa_max: float,
        radii: np.ndarray,
        slices: np.ndarray,
        wavelengths: np.ndarray,
        weights: np.ndarray,
        progress: Callable[[float], None] | None = None,
        reflectance: Reflectance | None = None,
        gain: np.ndarray | None = None,
        coarse: int | None = None,
    ) -> None:
        self.n_w, self.n_nodes = len(slices), len(nodes)
        if coarse is None:
            coarse = coarse_from(frequencies[1], radii, slices, wavelengths, weights, reflectance)
        self.coarse = coarse
        # factors[lambda, (n, w, c)]: everything that does not depend on the radius.
        kappa = 2.0 * np.pi * slices[:, None] / wavelengths
        lagrange = node_weights(nodes, kappa_max, kappa.ravel()).reshape(self.n_w, len(wavelengths), len(nodes))
        if gain is not None:
            lagrange = lagrange * gain[:, :, None]
        factors = np.einsum("lc,wln->lnwc", weights / wavelengths[:, None] ** 2, lagrange)
        factors = np.ascontiguousarray(factors.reshape(len(wavelengths), -1), dtype=np.float32)
        near = len(frequencies)
        if coarse < len(radii):
            last = radii[max(coarse - 1, 0)] / wavelengths[0] / frequencies[1]
            near = min(int(last) + 4, near)
        self.grids = [frequencies[:near], *([frequencies[::2]] if coarse < len(radii) else [])]

        def matrix(index: int) -> tuple[int, int, np.ndarray]:
            r, grid = radii[index], int(index >= coarse)
            step = frequencies[1] * (1 + grid)
            first, taps = cubic_lagrange(r / wavelengths / step, len(self.grids[grid]))
            seen = None if reflectance is None else reflectance(r, slices).astype(np.float32)
            low, product = self._banded(factors, first, taps.astype(np.float32), seen)
            return grid, low * self.n_nodes, product.reshape(-1, self.n_w * 3).T

        #: Grid, first value of a line of it, and matrix ``(n_w * 3, (f, n))`` of each radius, in column order.
        self.matrices: list[tuple[int, int, np.ndarray]] = []
        parts = [range(len(radii))[start : start + _RADII_A_TIME] for start in range(0, len(radii), _RADII_A_TIME)]
        with ThreadPoolExecutor(workers()) as pool:
            for made in pool.map(lambda part: [matrix(index) for index in part], parts):
                self.matrices += made
                if progress is not None:
                    progress(len(self.matrices) / len(radii))

    def _banded(
        self, factors: np.ndarray, first: np.ndarray, taps: np.ndarray, seen: np.ndarray | None
    ) -> tuple[int, np.ndarray]:
        """First frequency and ``(f, (n, w, c))`` sum over the wavelengths of factors and interpolation.

        ``first`` falls with the wavelength; ``seen`` is ``(n_w, L)``.
        """
        low, high = int(first[-1]), int(first[0]) + taps.shape[1]
        places = (first[:, None] - low + np.arange(taps.shape[1])).astype(np.int32)
        if seen is not None:
            by_slice = factors.reshape(len(first), self.n_nodes, self.n_w, 3)
            factors = (by_slice * seen.T[:, None, :, None]).reshape(factors.shape)
        return low, spread_product(places, taps, factors, high - low)

    def apply(self, intensities: Sequence[np.ndarray]) -> np.ndarray:
        """Integrate a block of angles.

        Parameters
        ----------
        intensities
            ``(m, n_f, n)`` float32 for each of `grids`, S = lambda^2 T, m^2.

        Returns
        -------
        ndarray
            ``(n_r, n_w, 3, m)`` float32, T in XYZ, 1/sr.
        """
        out = np.empty((len(self.matrices), self.n_w * 3, len(intensities[0])), np.float32)
        self.apply_into(intensities, [out])
        return out.reshape(len(out), self.n_w, 3, -1)

    def apply_into(self, intensities: Sequence[np.ndarray], out: Sequence[np.ndarray]) -> None:
        """The same, into arrays ``(n_r, n_w * 3, part of m)`` that take the angles in order."""
        lines = [each.reshape(len(each), -1) for each in intensities]
        targets, start = [], 0
        for each in out:
            targets.append((slice(start, start + each.shape[-1]), each))
            start += each.shape[-1]
        for index, (grid, first, matrix) in enumerate(self.matrices):
            for angles, target in targets:  # all of them while the matrix is in the cache
                values = lines[grid][angles, first : first + matrix.shape[1]]
                np.matmul(matrix, values.T, out=target[index])
                np.maximum(target[index], 0.0, out=target[index])


def coarse_from(
    step: float,
    radii: np.ndarray,
    slices: np.ndarray,
    wavelengths: np.ndarray,
    weights: np.ndarray,
    reflectance: Reflectance | None = None,
) -> int:
    """First radius from which on every second frequency will do.

    The intensities hold lags D up to some sigma_s, weighted with ``exp(-D^2 / (4 sigma_s^2))``. For each of them the
    integral over the light's wavelengths has a closed form, ``sum_l weight_l exp(2 pi i D r / lambda_l)``, which the
    sum over interpolated frequencies must meet. Wide spectra do from some tens of widths of the lobe on; those of
    lamps with lines never do.

    Parameters
    ----------
    step
        Of the frequencies, 1/m.
    radii, slices, wavelengths, weights, reflectance
        As in `SpectralSum`.

    Returns
    -------
    int
        Index into ``radii``; their number where none will do.
    """
    sigma_s = lobe_width(1.0) * RADIAL_STEP / step
    lags = np.linspace(0.0, LAG_CUT, 27)
    decay = np.exp(-0.25 * lags**2)[:, None]
    spectra = weights / wavelengths[:, None] ** 2
    found = len(radii)
    for index in range(len(radii) - 1, -1, -4):
        r = radii[index]
        light = spectra
        if reflectance is not None:
            seen = reflectance(r, slices[[0, len(slices) // 2, -1]])
            light = (spectra[:, None] * seen.T[:, :, None]).reshape(len(wavelengths), -1)
        light = light / np.maximum(light.sum(axis=0), 1e-30)
        place = r / wavelengths / (2.0 * step)
        first, taps = cubic_lagrange(place, int(place.max()) + 8)
        low = int(first.min())
        sums = np.zeros((int(first.max()) + 4 - low, light.shape[1]))
        for tap in range(4):
            np.add.at(sums, first + tap - low, taps[:, tap, None] * light)
        turn = 4.0j * np.pi * step * sigma_s * lags[:, None]
        exact = np.exp(turn * place) @ light
        error = np.abs(np.exp(turn * (low + np.arange(len(sums)))) @ sums - exact) * decay
        if error.max() > _COARSE_ERROR:
            break
        found = index
    return found
