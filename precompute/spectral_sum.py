# SPDX-License-Identifier: GPL-3.0-or-later
"""From intensities at nodes of kappa to XYZ slices: the integral over wavelength as matrix products.

For a slice |w| and a radius r, wavelength lambda looks at the frequency ``f = r / lambda`` and at
``kappa = 2 pi |w| / lambda``. Both the interpolation in kappa (polynomial through the nodes) and in
f (cubic Lagrange) are linear, so everything between the intensities S and the texels of one radius
is one matrix

    M[(w, c), (f, n)] = sum_lambda weight_c(lambda) / lambda^2  L_n(2 pi |w| / lambda)  C_f(r / lambda)

and the integral is ``M @ S``; no array is resampled.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .series import node_weights


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


def spectral_slices(
    intensity: np.ndarray,
    frequency_step: float,
    nodes: np.ndarray,
    kappa_max: float,
    radii: np.ndarray,
    slices: np.ndarray,
    wavelengths: np.ndarray,
    weights: np.ndarray,
    progress: Callable[[float], None] | None = None,
) -> np.ndarray:
    """Integrate over wavelength for every slice, radius and angle.

    Parameters
    ----------
    intensity
        ``(n_f, n, n_phi)`` float32, S = lambda^2 T at radial frequencies and kappa nodes, m^2.
    frequency_step
        Step of the radial frequencies, 1/m.
    nodes, kappa_max
        Chebyshev nodes and the end of their interval, 1/m.
    radii
        ``(n_r,)`` radii sqrt(u^2 + v^2).
    slices
        ``(n_w,)`` values of |w|.
    wavelengths, weights
        ``(L,)`` metres and ``(L, 3)`` from :func:`precompute.colour.spectral_weights`.
    progress
        Called with the fraction done.

    Returns
    -------
    ndarray
        ``(n_r, n_w, 3, n_phi)`` float32, T in XYZ, 1/sr.
    """
    count_f, count_n, n_phi = intensity.shape
    n_w = len(slices)
    # factors[(w, c, n), lambda]: everything that does not depend on the radius.
    kappa = 2.0 * np.pi * slices[:, None] / wavelengths
    lagrange = node_weights(nodes, kappa_max, kappa.ravel()).reshape(n_w, len(wavelengths), count_n)
    factors = np.einsum("lc,wln->wcnl", weights / wavelengths[:, None] ** 2, lagrange)
    factors = factors.reshape(-1, len(wavelengths)).astype(np.float32)
    out = np.empty((len(radii), n_w * 3, n_phi), np.float32)
    rows = np.arange(len(wavelengths))[:, None]
    for i, r in enumerate(radii):
        first, taps = cubic_lagrange(r / wavelengths / frequency_step, count_f)
        low, high = int(first.min()), int(first.max()) + 4
        radial = np.zeros((len(wavelengths), high - low), np.float32)
        np.add.at(radial, (rows, first[:, None] - low + np.arange(4)), taps)
        matrix = (factors @ radial).reshape(n_w * 3, count_n, high - low).transpose(0, 2, 1)
        np.matmul(matrix.reshape(n_w * 3, -1), intensity[low:high].reshape(-1, n_phi), out=out[i])
        if progress is not None and i % 16 == 0:
            progress(i / len(radii))
    np.maximum(out, 0.0, out=out)
    return out.reshape(len(radii), n_w, 3, n_phi)
