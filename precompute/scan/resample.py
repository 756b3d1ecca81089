# SPDX-License-Identifier: GPL-3.0-or-later
"""Finer pixels by bicubic interpolation, so that no false order comes into view.

The transform is periodic in u with period lambda / dx and |u| reaches 2: pixels above a quarter
of the shortest wavelength show orders that the surface does not have.
"""

from __future__ import annotations

import math

import numpy as np

from ..constants import PIXEL_MAX_M
from ..errors import ParameterError, SizeLimitError
from .heightfield import HeightField
from .missing import fill_missing

#: Most pixels of a refined patch (8192 x 8192).
LIMIT_PIXELS = 8192 * 8192


def refine_factors(field: HeightField, pixel_max_m: float = PIXEL_MAX_M) -> tuple[int, int]:
    """Whole numbers of new pixels for one old along x and y, so that none is larger than ``pixel_max_m``."""
    if not (np.isfinite(pixel_max_m) and pixel_max_m > 0):
        raise ParameterError(f"The largest pixel of {pixel_max_m} m makes no sense; give a positive length.")
    # Rounding must not split a pixel of just the allowed size.
    fx, fy = (max(1, math.ceil(step / pixel_max_m * (1.0 - 1e-9))) for step in (field.dx, field.dy))
    return fx, fy


def refine(field: HeightField, pixel_max_m: float = PIXEL_MAX_M, limit_pixels: int = LIMIT_PIXELS) -> HeightField:
    """Interpolate the heights to pixels of at most ``pixel_max_m``.

    Cubic splines along both axes; each old pixel is cut into a whole number of new ones, so the
    patch keeps its size. Missing points are filled first.

    Parameters
    ----------
    field
        The heightfield.
    pixel_max_m
        Largest pixel side in metres, lambda_min / 4 = 95 nm by default.
    limit_pixels
        Most pixels of the result.

    Returns
    -------
    HeightField
        The field itself where its pixels are small enough.

    Raises
    ------
    SizeLimitError
        If the result would have more than ``limit_pixels``.
    """
    fx, fy = refine_factors(field, pixel_max_m)
    if fx == 1 and fy == 1:
        return field
    rows, cols = field.shape
    if rows * fy * cols * fx > limit_pixels:
        raise SizeLimitError(
            f"Pixels of {1e9 * field.dx:.0f} x {1e9 * field.dy:.0f} nm need {rows * fy} x {cols * fx} pixels "
            f"of at most {1e9 * pixel_max_m:.0f} nm, above the limit of {limit_pixels}; crop the scan."
        )
    field = fill_missing(field)
    heights = _interpolated(_interpolated(field.heights, fy, 0), fx, 1)
    step = {"step": "refine", "factor_x": fx, "factor_y": fy, "from_m": [field.dx, field.dy]}
    return field.processed(
        step, heights=heights, dx=field.dx / fx, dy=field.dy / fy, missing=np.zeros(heights.shape, bool)
    )


def _interpolated(values: np.ndarray, factor: int, axis: int) -> np.ndarray:
    """Cubic spline along one axis, through the pixel centres and sampled at the centres of the new pixels."""
    if factor == 1:
        return values
    from scipy.interpolate import make_interp_spline

    count = values.shape[axis]
    old = np.arange(count) + 0.5
    new = (np.arange(count * factor) + 0.5) / factor
    # Not-a-knot ends: the outermost new centres lie less than half an old pixel outside, and the cubic goes on there.
    degree = 3 if count > 3 else 1
    return make_interp_spline(old, values, k=degree, axis=axis)(new)
