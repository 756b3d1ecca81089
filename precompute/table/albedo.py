# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedo of a table, for the energy-conserving form of the BRDF.

``a(wr) = integral f cos_i dwi`` with R = 1. Since ``du dv = cos_i dwi`` for a fixed wr,

    a(wr) = integral (1 + wi.wr)^2 / (cos_i cos_r w^2) T(u, v, w) du dv

over the (u, v) whose ``wi_xy = -(u, v) - wr_xy`` lies in the unit disc. The table's own radii
are the quadrature nodes, so the specular peak is resolved however narrow it is. For a fixed
theta_r everything but T depends on the azimuths through phi - phi_r only: one circular
correlation gives all phi_r at once.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from .layout import TableLayout

#: Azimuthal sectors of the quadrature.
SECTORS = 144

#: A component of white below this part of Y says nothing (light of a narrow band): it is left out.
DARK_WHITE = 1e-4

#: The last polar angle is kept off the horizon, where cos_r = 0.
THETA_LAST = np.radians(89.5)


def albedo_map(
    texels: np.ndarray,
    layout: TableLayout,
    white: np.ndarray,
    progress: Callable[[float], None] | None = None,
    index: float = 1.0,
) -> np.ndarray:
    """Albedo on the grid of the albedo tile.

    Parameters
    ----------
    texels
        ``(n_r, n_w, 3, n_phi)`` the table's nodes, ``T / |w|^power`` in XYZ, which the renderer interpolates
        linearly in column, row and slice; the quadrature integrates that interpolant. Or what `sector_means` made of
        them.
    layout
        The table's coordinates.
    white
        ``(3,)`` XYZ of the illuminant with Y = 1.
    progress
        Called with the fraction done.
    index
        Refractive index n of a lacquer over the relief. Inside it ``sin' = sin / n``, ``w' = n (cos_i' + cos_r')`` and
        ``du dv = n^2 cos_i' dwi'``, so that the part of the light that leaves again is the same integral over the
        same (u, v) with the cosines of the inside and ``w'/n``.

    Returns
    -------
    ndarray
        ``(n_albedo_phi, n_theta)``; the largest of X, Y and Z relative to white.
    """
    from numpy.fft import rfft

    sectors = min(SECTORS, layout.n_phi)
    means = texels if texels.shape[-1] == sectors else sector_means(texels, sectors)
    spectrum = rfft(means.astype(np.float32), axis=-1)  # (n_r, n_w, 3, m)
    radii = layout.radii
    edges = np.concatenate([[0.0], 0.5 * (radii[1:] + radii[:-1]), [radii[-1]]])
    area = (_hat_areas(radii) * (2.0 * np.pi / sectors))[:, None]
    delta = 2.0 * np.pi / sectors
    alpha = (np.arange(sectors) + 0.5) * delta
    half_extent = 0.5 * np.hypot(np.diff(edges)[:, None], radii[:, None] * delta)
    r = radii[:, None]
    result = np.empty((layout.n_albedo_phi, layout.n_theta))
    thetas = np.minimum(np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1)), THETA_LAST)
    turn = np.arange(layout.n_albedo_phi) * (2.0 * np.pi / layout.n_albedo_phi)
    order = np.arange(spectrum.shape[-1])
    # Azimuth phi_r of the albedo's rows plus the kernel's first alpha, relative to the middle of sector 0.
    middle = 0.5 * delta - np.pi / layout.n_phi
    phases = np.exp(1j * order * (turn[:, None] + 0.5 * delta - middle))
    bright = white > DARK_WHITE
    for column, theta in enumerate(thetas):
        sin_r, cos_r = np.sin(theta), np.cos(theta)
        rho = np.sqrt(np.maximum(r**2 + 2.0 * r * sin_r * np.cos(alpha) + sin_r**2, 0.0))
        inside = np.minimum(rho, 1.0)
        cos_i = np.sqrt(1.0 - (inside / index) ** 2)
        # 1 / cos_i is integrable but infinite on the rim: its mean over the cell's extent in rho.
        inverse_cos = np.arcsin(np.minimum(rho + half_extent, 1.0)) - np.arcsin(np.clip(rho - half_extent, -1.0, 1.0))
        inverse_cos /= 2.0 * half_extent
        if index > 1.0:  # no infinity: what lies outside the horizon is left out
            cos_r = np.sqrt(1.0 - (sin_r / index) ** 2)
            inverse_cos = np.clip(0.5 + (1.0 - rho) / (2.0 * half_extent), 0.0, 1.0) / cos_i
        w = index * (cos_i + cos_r)
        # wi.wr + 1 = |wi + wr|^2 / 2 = (r^2 + w^2) / 2, inside a lacquer with r / n and w / n
        weight = (0.5 * (r**2 + w**2) / index**2) ** 2 / (cos_r * (w / index) ** 2) * inverse_cos * area
        position = layout.slice_coordinate(w)
        lower = np.minimum(position.astype(int), layout.n_w - 2)
        blend = position - lower
        kernel = np.zeros((layout.n_r, layout.n_w, sectors), np.float32)
        ir, ia = np.indices(lower.shape)
        factor = weight * w**layout.power
        kernel[ir, lower, ia] = factor * (1.0 - blend)
        kernel[ir, lower + 1, ia] = factor * blend
        kernel_spectrum = rfft(kernel, axis=-1)
        product = np.einsum("rwm,rwcm->cm", np.conj(kernel_spectrum), spectrum)
        product[:, 1:] *= 2.0
        if sectors % 2 == 0:
            product[:, -1] *= 0.5
        # sum_alpha kernel(alpha) T(phi_r + alpha) for any phi_r, by its Fourier series
        albedo = (phases[:, None, :] * product).real.sum(-1) / sectors
        result[:, column] = (albedo[:, bright] / white[bright]).max(-1)
        if progress is not None:
            progress((column + 1) / len(thetas))
    return np.maximum(result, 0.0)


def _hat_areas(radii: np.ndarray) -> np.ndarray:
    """integral hat_i(r) r dr for the piecewise linear hat functions of the radii."""
    step = np.diff(radii)
    areas = np.zeros(len(radii))
    areas[:-1] += step * (2.0 * radii[:-1] + radii[1:]) / 6.0
    areas[1:] += step * (radii[:-1] + 2.0 * radii[1:]) / 6.0
    return areas


def sector_means(texels: np.ndarray, sectors: int) -> np.ndarray:
    """Means over ``sectors`` equal sectors that start at phi = 0; row j of the table stands for its own angle."""
    n_phi = texels.shape[-1]
    cumulative = np.concatenate([np.zeros((*texels.shape[:-1], 1)), np.cumsum(texels, -1, dtype=np.float64)], -1)
    edges = np.arange(sectors + 1) * (n_phi / sectors)
    whole = edges.astype(int)
    part = edges - whole
    at = cumulative[..., whole] + part * texels[..., whole % n_phi]
    return np.diff(at, axis=-1) * (sectors / n_phi)
