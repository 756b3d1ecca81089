# SPDX-License-Identifier: GPL-3.0-or-later
"""Gaussian smoothing against the instrument's noise."""

from __future__ import annotations

import math

import numpy as np

from ..errors import ParameterError
from .heightfield import HeightField


def smooth(field: HeightField, sigma_m: float) -> HeightField:
    """Convolve the heights with a Gaussian.

    Missing points take no part (the weights of the valid ones are normalised) and stay missing.

    Parameters
    ----------
    field
        The heightfield.
    sigma_m
        Standard deviation in metres; 0 leaves the field as it is.

    Raises
    ------
    ParameterError
        If ``sigma_m`` is negative, not finite, or larger than a quarter of the patch.
    """
    if not (math.isfinite(sigma_m) and 0.0 <= sigma_m <= 0.25 * min(field.size_m)):
        raise ParameterError(
            f"Smoothing over {sigma_m} m makes no sense; give a length from 0 to {0.25 * min(field.size_m):.3g} m."
        )
    if sigma_m == 0.0:
        return field
    from scipy.ndimage import gaussian_filter

    sigmas = (sigma_m / field.dy, sigma_m / field.dx)
    if field.missing.any():
        weights = gaussian_filter((~field.missing).astype(np.float64), sigmas, mode="nearest")
        values = gaussian_filter(np.where(field.missing, 0.0, field.heights), sigmas, mode="nearest")
        heights = np.where(field.missing, np.nan, values / np.maximum(weights, 1e-12))
    else:
        heights = gaussian_filter(field.heights, sigmas, mode="nearest")
    return field.processed({"step": "smooth", "sigma_m": float(sigma_m)}, heights=heights)
