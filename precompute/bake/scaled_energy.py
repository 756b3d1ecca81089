# SPDX-License-Identifier: GPL-3.0-or-later
"""Bounds of single wavelengths (`precompute.bake.energy`) of the stretched and deepened surfaces that a table serves.

The light of a wavelength is summed once; a scale moves its rings, a depth the slices that it is taken from. Where it
goes depends on the wavelength over the scale alone, so that both are whole steps of the same octave.
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from ..table import scaled_bound
from ..table.scaled_albedo import albedo_ratios
from ..table.table import SpectralTable
from .energy import Albedos
from .transforms import workers

#: Wavelengths an octave, which the scales are whole steps of, and the width of rings of frequencies over their radius.
_STEPS, _RING = 8, 0.06


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
    few = _wavelengths(float(wavelengths[0]), float(wavelengths[-1]))
    steps = np.rint(-_STEPS * np.log2(scaled_bound.SCALES)).astype(int)

    def light(wavelength: float) -> np.ndarray:
        at = None if gain is None else np.array([np.interp(wavelength, wavelengths, row) for row in gain])
        return albedos.light(wavelength, at, most_s).reshape(-1, scaled_bound.N_AZIMUTHS)

    def of_ratio(ratio: int) -> list[tuple[int, int, np.ndarray]]:
        """All wavelengths over scales that are ``few[0] / most_s 2^(ratio / _STEPS)`` have their cells in common."""
        cells = albedos.cells(few[0] / most_s * 2.0 ** (ratio / _STEPS), thetas, depths)
        return [
            (scale, depth, towards.needed(lights[number], thetas, divisors[scale, depth]))
            for scale, number in enumerate(ratio - steps)
            if 0 <= number < len(few)
            for depth, towards in enumerate(cells)
        ]

    bound = np.ones((n_scales, n_depths, len(thetas), scaled_bound.N_AZIMUTHS))
    with ThreadPoolExecutor(workers()) as pool:
        lights = list(pool.map(light, few))
        for found in pool.map(of_ratio, range(len(few) + steps.max())):
            for scale, depth, asked in found:
                np.maximum(bound[scale, depth], asked, out=bound[scale, depth])
    return bound


def _wavelengths(first: float, last: float) -> np.ndarray:
    """As many as fit between two, evenly in their logarithm."""
    count = int(np.floor(_STEPS * np.log2(last / first))) + 1
    return np.sqrt(first * last) * 2.0 ** ((np.arange(count) - 0.5 * (count - 1)) / _STEPS)
