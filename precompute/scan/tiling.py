# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches that repeat without a seam: by blending opposite edges, or by a crop to whole periods."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from .heightfield import HeightField
from .lattice import find_lattice
from .missing import fill_missing

METHODS = ("blend", "period")

#: A crop keeps at least this part of each side.
_LEAST_SIDE = 0.7


def make_tileable(field: HeightField, method: str = "blend", fraction: float = 0.1) -> HeightField:
    """Make opposite edges fit.

    Parameters
    ----------
    field
        The heightfield, levelled; missing points are filled.
    method
        ``blend`` cross-fades a band at one edge with the band at the opposite edge and keeps the
        roughness in it; ``period`` crops both sides to whole numbers of the periods that
        :func:`~precompute.scan.lattice.find_lattice` finds (and resamples by less than a pixel).
    fraction
        Width of the band as a part of the side, for ``blend``.

    Returns
    -------
    HeightField
        Smaller by the band or by what the crop leaves over.

    Raises
    ------
    ParameterError
        If the method is not known, the fraction is not between 0 and 0.5, or no period was found.
    """
    if method not in METHODS:
        raise ParameterError(f"There is no tiling '{method}'; choose one of {', '.join(METHODS)}.")
    field = fill_missing(field)
    if method == "period":
        return _cropped(field)
    if not 0.0 < fraction <= 0.5:
        raise ParameterError(f"A band of {fraction} of the side makes no sense; give more than 0 and at most 0.5.")
    bands = [max(1, round(fraction * count)) for count in field.shape]
    if min(count - band for count, band in zip(field.shape, bands, strict=True)) < 2:
        raise ParameterError("The patch is too small to be blended; use more pixels or a smaller band.")
    heights = _blended(_blended(field.heights, bands[0], 0), bands[1], 1)
    step = {"step": "tile", "method": "blend", "band_rows": bands[0], "band_cols": bands[1]}
    return field.processed(step, heights=heights, missing=np.zeros(heights.shape, bool))


def _blended(heights: np.ndarray, band: int, axis: int) -> np.ndarray:
    """The last ``band`` lines faded into the first ones and cut off."""
    lines = np.moveaxis(heights, axis, 0)
    mean = lines.mean()
    first, last = lines[:band] - mean, lines[-band:] - mean
    weight = (0.5 - 0.5 * np.cos(np.pi * (np.arange(band) + 0.5) / band))[:, None]
    # Two unrelated structures would lose up to 30 percent of their roughness where they mix.
    product = np.sqrt((first**2).mean() * (last**2).mean())
    correlation = float(np.clip((first * last).mean() / product, 0.0, 1.0)) if product > 0.0 else 1.0
    norm = np.sqrt(weight**2 + (1.0 - weight) ** 2 + 2.0 * correlation * weight * (1.0 - weight))
    mixed = (weight * first + (1.0 - weight) * last) / norm + mean
    return np.moveaxis(np.concatenate([mixed, lines[band:-band]]), 0, axis)


def _cropped(field: HeightField) -> HeightField:
    lattice = find_lattice(field)
    if not len(lattice.frequencies):
        raise ParameterError("The surface has no period to crop to; blend its edges instead.")
    size_x = _whole_periods(lattice.frequencies[:, 0], field.size_m[0])
    size_y = _whole_periods(lattice.frequencies[:, 1], field.size_m[1])
    heights, dx = _resampled(field.heights, field.dx, size_x, 1)
    heights, dy = _resampled(heights, field.dy, size_y, 0)
    step = {"step": "tile", "method": "period", "frequencies_per_m": lattice.frequencies.tolist()}
    return field.processed(step, heights=heights, dx=dx, dy=dy, missing=np.zeros(heights.shape, bool))


def _whole_periods(frequencies: np.ndarray, size: float) -> float:
    """The length, at least 0.7 of ``size``, that holds whole numbers of all periods best; the longest of equals."""
    frequencies = frequencies[np.abs(frequencies) * size > 0.5]
    if not len(frequencies):
        return size
    lengths = np.linspace(_LEAST_SIDE * size, size, 20001)
    misfit = (1.0 - np.cos(2.0 * np.pi * lengths[:, None] * frequencies[None, :])).sum(axis=1)
    good = np.flatnonzero(misfit <= misfit.min() + 1e-3)
    # Of the longest run of good lengths, the best: its middle lies on the whole number.
    run = good[good > good[-1] - 0.25 / np.abs(frequencies).max() / (lengths[1] - lengths[0])]
    return float(lengths[run[np.argmin(misfit[run])]])


def _resampled(heights: np.ndarray, step: float, size: float, axis: int) -> tuple[np.ndarray, float]:
    """The first ``size`` metres along an axis on pixels that divide it, and their size."""
    from scipy.interpolate import make_interp_spline

    count = heights.shape[axis]
    new_count = max(2, round(size / step))
    new_step = size / new_count
    if new_count == count and abs(new_step - step) < 1e-9 * step:
        return heights, step
    spline = make_interp_spline((np.arange(count) + 0.5) * step, heights, k=min(3, count - 1), axis=axis)
    return spline((np.arange(new_count) + 0.5) * new_step), new_step
