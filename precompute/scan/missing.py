# SPDX-License-Identifier: GPL-3.0-or-later
"""Missing points: filled smoothly from their neighbours, and counted."""

from __future__ import annotations

import numpy as np

from .heightfield import HeightField
from .levelling import fitted_surface


def fill_missing(field: HeightField) -> HeightField:
    """Fill missing points from their surroundings.

    The plane through the valid points is taken off first, so that a hole in a tilted scan is
    filled along the tilt; what is left is averaged over ever coarser blocks of valid pixels and
    interpolated back into the holes (push-pull). Valid heights do not change.

    Parameters
    ----------
    field
        The heightfield.

    Returns
    -------
    HeightField
        Without missing points; the step ``fill`` in ``processing`` tells how many there were.
        The field itself where nothing is missing.
    """
    count = int(field.missing.sum())
    if count == 0:
        return field
    valid = ~field.missing
    plane = fitted_surface(field.heights, valid, "plane")
    residual = np.where(valid, field.heights - plane, 0.0)
    filled = np.where(valid, field.heights, plane + _push_pull(residual, valid.astype(np.float64)))
    step = {"step": "fill", "count": count, "fraction": count / field.missing.size}
    return field.processed(step, heights=filled, missing=np.zeros(field.shape, bool))


def _push_pull(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """``values`` where the weight is 1, else the average of the surroundings at the scale of the hole."""
    if weights.min() > 0.0:
        return values
    rows, cols = values.shape
    padding = ((0, rows % 2), (0, cols % 2))
    weighted = np.pad(values * weights, padding)
    padded = np.pad(weights, padding)
    total = padded.reshape(padded.shape[0] // 2, 2, padded.shape[1] // 2, 2).sum(axis=(1, 3))
    sums = weighted.reshape(total.shape[0], 2, total.shape[1], 2).sum(axis=(1, 3))
    coarse = np.divide(sums, total, out=np.zeros_like(sums), where=total > 0.0)
    coarse = _push_pull(coarse, (total > 0.0).astype(np.float64))
    return weights * values + (1.0 - weights) * _doubled(coarse)[:rows, :cols]


def _doubled(coarse: np.ndarray) -> np.ndarray:
    """Twice the resolution by linear interpolation between pixel centres, constant beyond the outermost."""
    for axis in (0, 1):
        lines = np.moveaxis(coarse, axis, 0)
        before = np.concatenate([lines[:1], lines[:-1]])
        after = np.concatenate([lines[1:], lines[-1:]])
        fine = np.empty((2 * len(lines), lines.shape[1]))
        fine[0::2] = 0.75 * lines + 0.25 * before
        fine[1::2] = 0.75 * lines + 0.25 * after
        coarse = np.moveaxis(fine, 0, axis)
    return coarse
