# SPDX-License-Identifier: GPL-3.0-or-later
"""Dust clip and crop."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from .heightfield import HeightField


def clip(field: HeightField, percent: float | None) -> HeightField:
    """Keep the middle ``percent`` of the heights: what lies beyond is clamped to the limits.

    Dust and pits reach far beyond the structure and would cost terms of the series without
    telling anything about it.

    Parameters
    ----------
    field
        The heightfield.
    percent
        ``99.9`` clamps to the percentiles 0.05 and 99.95 (linear interpolation) of the valid
        heights; None leaves the field as it is.

    Raises
    ------
    ParameterError
        If ``percent`` is not above 0 and up to 100.
    """
    if percent is None:
        return field
    if not 0.0 < percent <= 100.0:
        raise ParameterError(f"The clip of {percent} percent makes no sense; keep more than 0 and at most 100 percent.")
    outside = (100.0 - percent) / 2.0
    low, high = np.percentile(field.valid, [outside, 100.0 - outside])
    step = {"step": "clip", "percent": float(percent), "low_m": float(low), "high_m": float(high)}
    return field.processed(step, heights=np.clip(field.heights, low, high))


def crop(
    field: HeightField,
    x_m: tuple[float, float] | None = None,
    y_m: tuple[float, float] | None = None,
) -> HeightField:
    """The part of a heightfield whose pixel centres lie in a rectangle.

    Parameters
    ----------
    field
        The heightfield.
    x_m, y_m
        Lower and upper limit in metres from the left and from the bottom; None keeps all.

    Raises
    ------
    ParameterError
        If fewer than 2 x 2 pixels are left.
    """
    rows, cols = field.shape
    left, right = crop_pixels(x_m, field.dx, cols, "x")
    bottom, top = crop_pixels(y_m, field.dy, rows, "y")
    if (left, right, bottom, top) == (0, cols, 0, rows):
        return field
    step = {"step": "crop", "cols": [left, right], "rows": [bottom, top]}
    return field.processed(
        step, heights=field.heights[bottom:top, left:right], missing=field.missing[bottom:top, left:right]
    )


def crop_pixels(limits_m: tuple[float, float] | None, step_m: float, count: int, name: str) -> tuple[int, int]:
    """First pixel and the one behind the last whose centres ``(i + 1/2) step`` lie within the limits.

    Raises
    ------
    ParameterError
        If the limits make no sense or fewer than two pixels are left.
    """
    if limits_m is None:
        return 0, count
    low, high = limits_m
    if not (np.isfinite(low) and np.isfinite(high) and low < high):
        raise ParameterError(f"The crop along {name} goes from {low} m to {high} m; give a lower and an upper limit.")
    # Centres on a limit count as inside in spite of rounding.
    first = max(0, int(np.ceil(low / step_m - 0.5 - 1e-6)))
    last = min(count, int(np.floor(high / step_m - 0.5 + 1e-6)) + 1)
    if last - first < 2:
        raise ParameterError(
            f"The crop along {name} leaves {max(0, last - first)} of {count} pixels; choose a larger part of the scan."
        )
    return first, last
