# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single wavelengths (`precompute.bake.energy`) of the stretched and deepened surfaces that a table serves.

The light of a wavelength is summed once; a scale moves its rings, a depth the slices that it is taken from.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..table import scaled_bound
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
    albedos = Albedos(frequencies, means, nodes, kappa_max, layout, layout.index, None, _RING)
    most_s, most_q = layout.headroom
    n_scales, n_depths = len(scaled_bound.SCALES), len(scaled_bound.DEPTHS)
    depths = [most_q * q for q in scaled_bound.DEPTHS]
    pairs = [(most_s * s, q) for s in scaled_bound.SCALES for q in depths]
    tile_theta = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
    tile_phi = np.arange(scaled_bound.N_AZIMUTHS) * layout.n_albedo_phi // scaled_bound.N_AZIMUTHS
    own = np.stack([np.interp(thetas, tile_theta, row) for row in albedo[tile_phi]], -1)
    divisors = np.maximum((own * albedo_ratios(table, pairs)).min(-1), 1.0).reshape(n_scales, n_depths, -1)
    few = np.linspace(wavelengths[0], wavelengths[-1], WAVELENGTHS)

    def of_wavelength(wavelength: float) -> np.ndarray:
        at = None if gain is None else np.array([np.interp(wavelength, wavelengths, row) for row in gain])
        light = albedos.light(wavelength, at, most_s).reshape(-1, scaled_bound.N_AZIMUTHS)
        found = [
            [each.needed(light, thetas, divisor) for each, divisor in zip(cells, at_scale, strict=True)]
            for cells, at_scale in zip(
                (albedos.cells(wavelength / (most_s * s), thetas, depths) for s in scaled_bound.SCALES),
                divisors,
                strict=True,
            )
        ]
        return np.array(found)

    with ThreadPoolExecutor(workers()) as pool:
        return np.stack(list(pool.map(of_wavelength, few))).max(0)
