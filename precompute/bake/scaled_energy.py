# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single wavelengths (`precompute.bake.energy`) of the stretched and deepened surfaces that a table serves.

The light of a wavelength is summed once; a scale moves its rings, a depth the slices that it is taken from.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..table import scaled_bound
from ..table.cells import Divisor, needed
from ..table.scaled_albedo import albedo_ratios
from ..table.table import SpectralTable
from .energy import WAVELENGTHS, Albedos
from .transforms import workers

#: Width of rings of frequencies over their radius.
_RING = 0.06


def scaled_bounds(
    table: SpectralTable,
    albedo: np.ndarray,
    frequencies: np.ndarray,
    means: np.ndarray,
    nodes: np.ndarray,
    kappa_max: float,
    wavelengths: np.ndarray,
    gain: np.ndarray | None = None,
) -> np.ndarray:
    """``(scales, depths, thetas, azimuths)`` on the grid of `precompute.table.scaled_bound`.

    Parameters
    ----------
    table
        What was baked.
    albedo
        ``(n_albedo_phi, n_theta)`` its directional albedo with R = 1.
    frequencies, means, nodes, kappa_max, wavelengths, gain
        As for `precompute.bake.energy.energy`.
    """
    layout, thetas = table.layout, scaled_bound.THETAS
    albedos = Albedos(frequencies, means, nodes, kappa_max, layout, layout.index, _RING)
    most_s, most_q = layout.headroom
    n_scales, n_depths = len(scaled_bound.SCALES), len(scaled_bound.DEPTHS)
    depths = [most_q * q for q in scaled_bound.DEPTHS]
    pairs = [(most_s * s, q) for s in scaled_bound.SCALES for q in depths]
    tile_theta = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
    tile_phi = np.arange(scaled_bound.N_AZIMUTHS) * layout.n_albedo_phi // scaled_bound.N_AZIMUTHS
    own = np.stack([np.interp(thetas, tile_theta, row) for row in albedo[tile_phi]], -1)
    least = (own * albedo_ratios(table, pairs)).min(-1).reshape(n_scales, n_depths, -1)
    few = np.linspace(wavelengths[0], wavelengths[-1], WAVELENGTHS)
    divisors = [Divisor(thetas, least[:, k]) for k in range(n_depths)]

    def of_wavelength(wavelength: float) -> np.ndarray:
        at = None if gain is None else np.array([np.interp(wavelength, wavelengths, row) for row in gain])
        light = albedos.light(wavelength, at, most_s)
        cells = albedos.cells([wavelength / (most_s * s) for s in scaled_bound.SCALES], thetas)
        left = [cells.left(light, albedos.slices, q, each) for q, each in zip(depths, divisors, strict=True)]
        return needed(np.stack(left, axis=1))

    with ThreadPoolExecutor(workers()) as pool:
        return np.stack(list(pool.map(of_wavelength, few))).max(0)
