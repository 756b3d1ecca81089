# SPDX-License-Identifier: GPL-3.0-or-later
"""From intensities at nodes of kappa to XYZ slices: the integral over wavelength as matrix products.

For a slice |w| and a radius r, wavelength lambda looks at the frequency ``f = r / lambda`` and at
``kappa = 2 pi |w| / lambda``. Both the interpolation in kappa (polynomial through the nodes) and in
f (cubic Lagrange) are linear, so everything between the intensities S and the texels of one radius
is one matrix

    M[(w, c), (f, n)] = sum_lambda weight_c(lambda) / lambda^2  L_n(2 pi |w| / lambda)  C_f(r / lambda)

and the integral is ``M @ S``; no array is resampled. What depends on the wavelength, the radius and the slice
alone goes into the same matrix: the reflectance of a stack, ``R(lambda, theta_half)`` with
``cos(theta_half) = |(u, v, w)| / (2 n) = min(1, sqrt(r^2 + w^2) / (2 n))``, and the cap of the energy.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..stack import Material, Stack
from .series import node_weights


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
        ``(n_f,)`` radial frequencies of the intensities, evenly spaced from 0, 1/m.
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
    ) -> None:
        self.n_w = len(slices)
        # factors[(w, c, n), lambda]: everything that does not depend on the radius.
        kappa = 2.0 * np.pi * slices[:, None] / wavelengths
        lagrange = node_weights(nodes, kappa_max, kappa.ravel()).reshape(self.n_w, len(wavelengths), len(nodes))
        if gain is not None:
            lagrange = lagrange * gain[:, :, None]
        factors = np.einsum("lc,wln->wcnl", weights / wavelengths[:, None] ** 2, lagrange)
        factors = factors.reshape(-1, len(wavelengths)).astype(np.float32)
        rows = np.arange(len(wavelengths))[:, None]
        #: First frequency and matrix ``(n_w * 3, (f, n))`` of each radius.
        self.matrices: list[tuple[int, np.ndarray]] = []
        for done, r in enumerate(radii, 1):
            first, taps = cubic_lagrange(r / wavelengths / frequencies[1], len(frequencies))
            low, high = int(first.min()), int(first.max()) + 4
            radial = np.zeros((len(wavelengths), high - low), np.float32)
            np.add.at(radial, (rows, first[:, None] - low + np.arange(4)), taps)
            if reflectance is None:
                product = factors @ radial
            else:
                seen = reflectance(r, slices).astype(np.float32)
                product = (factors.reshape(self.n_w, -1, len(wavelengths)) * seen[:, None]) @ radial
            matrix = product.reshape(self.n_w * 3, len(nodes), high - low).transpose(0, 2, 1)
            self.matrices.append((low, matrix.reshape(self.n_w * 3, -1)))
            if progress is not None:
                progress(done / len(radii))
        self.n_nodes = len(nodes)

    def apply(self, intensity: np.ndarray) -> np.ndarray:
        """Integrate a block of angles.

        Parameters
        ----------
        intensity
            ``(n_f, n, m)`` float32, S = lambda^2 T, m^2.

        Returns
        -------
        ndarray
            ``(n_r, n_w, 3, m)`` float32, T in XYZ, 1/sr.
        """
        flat = intensity.reshape(-1, intensity.shape[-1])
        out = np.empty((len(self.matrices), self.n_w * 3, intensity.shape[-1]), np.float32)
        for (low, matrix), target in zip(self.matrices, out, strict=True):
            start = low * self.n_nodes
            np.matmul(matrix, flat[start : start + matrix.shape[1]], out=target)
        np.maximum(out, 0.0, out=out)
        return out.reshape(len(out), self.n_w, 3, -1)
