# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional albedo of a table, for the energy-conserving form of the BRDF.

``a(wr) = integral f cos_i dwi`` with R = 1. Since ``du dv = cos_i dwi`` for a fixed wr,

    a(wr) = integral (1 + wi.wr)^2 / (cos_i cos_r w^2) T(u, v, w) du dv

over the (u, v) whose ``wi_xy = -(u, v) - wr_xy`` lies in the unit disc. The table's own radii
are the quadrature nodes, so the specular peak is resolved however narrow it is. For a fixed
theta_r everything but T depends on the azimuths through cos(phi - phi_r) only: one circular
correlation gives all phi_r at once, and its kernel is even, so that half the sectors and a real
cosine series do.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..scipy_kernels import scattered
from .layout import TableLayout

#: Azimuthal sectors of the quadrature.
SECTORS = 144

#: Polar angles whose kernels are made at a time; bounds the memory.
_THETAS_A_TIME = 4

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
    sectors = min(SECTORS, layout.n_phi)
    means = texels if texels.shape[-1] == sectors else sector_means(texels, sectors)
    radii = layout.radii
    edges = np.concatenate([[0.0], 0.5 * (radii[1:] + radii[:-1]), [radii[-1]]])
    delta = 2.0 * np.pi / sectors
    area = _hat_areas(radii) * delta
    half = (sectors + 1) // 2
    alpha = (np.arange(half) + 0.5) * delta
    half_extent = 0.5 * np.hypot(np.diff(edges), radii * delta)
    r = radii
    thetas = np.minimum(np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1)), THETA_LAST)
    order = np.arange(sectors // 2 + 1)
    # Fourier series of the means over the sectors, (order, (r, w), (c, re and im)), and the kernel's cosines.
    turns = np.exp(-1j * delta * np.outer(order, np.arange(sectors)))
    flat = means.reshape(layout.n_r * layout.n_w, 3, sectors).astype(np.float32, copy=False)
    series = np.empty((len(order), layout.n_r * layout.n_w, 6), np.float32)
    for component in range(3):
        for number, part in enumerate((turns.real, turns.imag)):
            series[:, :, 2 * component + number] = part.astype(np.float32) @ flat[:, component].T
    cosines = 2.0 * np.cos(np.outer(order, alpha))
    if sectors % 2:
        cosines[:, -1] *= 0.5  # the middle sector is its own mirror image
    cosines = cosines.astype(np.float32)
    place = np.arange(layout.n_r, dtype=np.int32) * layout.n_w

    def products(first: int) -> np.ndarray:
        """``(order, thetas, 3)`` coefficients of the correlation with T, for some polar angles."""
        theta = thetas[first : first + _THETAS_A_TIME, None]
        sin_r, cos_r = np.sin(theta), np.cos(theta)
        rho = np.sqrt(np.maximum(r**2 + 2.0 * r * sin_r * np.cos(alpha)[:, None, None] + sin_r**2, 0.0))
        inside = np.minimum(rho, 1.0)
        cos_i = np.sqrt(1.0 - (inside / index) ** 2)
        if index > 1.0:  # no infinity: what lies outside the horizon is left out
            cos_r = np.sqrt(1.0 - (sin_r / index) ** 2)
            inverse_cos = np.clip(0.5 + (1.0 - rho) / (2.0 * half_extent), 0.0, 1.0) / cos_i
        else:
            # 1 / cos_i is integrable but infinite on the rim: its mean over the cell's extent in rho.
            outer, inner = np.minimum(rho + half_extent, 1.0), np.clip(rho - half_extent, -1.0, 1.0)
            inverse_cos = (np.arcsin(outer) - np.arcsin(inner)) / (2.0 * half_extent)
        w = index * (cos_i + cos_r)
        # wi.wr + 1 = |wi + wr|^2 / 2 = (r^2 + w^2) / 2, inside a lacquer with r / n and w / n
        weight = (0.5 * (r**2 + w**2) / index**2) ** 2 / (cos_r * (w / index) ** 2) * inverse_cos * area
        factor = weight * layout.gain(w)
        position = layout.slice_coordinate(w)
        lower = np.minimum(position.astype(np.int32), layout.n_w - 2)
        blend = position - lower
        at, share = np.empty((*w.shape, 2), np.int32), np.empty((*w.shape, 2), np.float32)
        at[..., 0] = place + lower
        at[..., 1] = at[..., 0] + 1
        share[..., 0] = factor * (1.0 - blend)
        share[..., 1] = factor * blend
        terms = 2 * layout.n_r
        kernel = scattered(at.reshape(-1, terms), share.reshape(-1, terms), layout.n_r * layout.n_w)
        even = (cosines @ kernel.reshape(half, -1)).reshape(len(order), len(theta), -1)
        found = (even @ series).reshape(len(order), len(theta), 3, 2)
        return found[..., 0] + 1j * found[..., 1]

    starts = range(0, layout.n_theta, _THETAS_A_TIME)
    parts = []
    with ThreadPoolExecutor(min(os.cpu_count() or 1, len(starts))) as pool:
        for part in pool.map(products, starts):
            parts.append(part)
            if progress is not None:
                progress(len(parts) / len(starts))
    product = np.concatenate(parts, axis=1)
    product[1:] *= 2.0
    if sectors % 2 == 0:
        product[-1] *= 0.5
    # sum_alpha kernel(alpha) T(phi_r + alpha) for any phi_r, by its Fourier series, from the middle of sector 0 on.
    middle = 0.5 * delta - np.pi / layout.n_phi
    turn = np.arange(layout.n_albedo_phi) * (2.0 * np.pi / layout.n_albedo_phi)
    phases = np.exp(1j * np.outer(turn - middle, order))
    albedo = np.tensordot(phases, product, 1).real / sectors
    bright = white > DARK_WHITE
    return np.maximum((albedo[..., bright] / white[bright]).max(-1), 0.0)


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
    lines = texels.reshape(-1, n_phi)
    if n_phi % sectors == 0:
        # Sums over a few neighbours are slow as such; neighbours of all sectors at a time are quick.
        each = n_phi // sectors
        means = lines[:, ::each].astype(np.float32)
        for start in range(1, each):
            means += lines[:, start::each]
        means *= np.float32(1.0 / each)
        return means.reshape(*texels.shape[:-1], sectors)
    edges = np.arange(sectors + 1) * (n_phi / sectors)
    means = np.empty((len(lines), sectors), np.float32)
    # Some sectors at a time: each is a sum over few rows.
    for start in range(0, sectors, 12):
        stop = min(start + 12, sectors)
        rows = np.arange(int(edges[start]), min(int(np.ceil(edges[stop])), n_phi))[:, None]
        share = np.minimum(edges[start + 1 : stop + 1], rows + 1) - np.maximum(edges[start:stop], rows)
        part = np.maximum(share, 0.0).astype(np.float32) * np.float32(sectors / n_phi)
        means[:, start:stop] = lines[:, rows[0, 0] : rows[-1, 0] + 1] @ part
    return means.reshape(*texels.shape[:-1], sectors)
