# SPDX-License-Identifier: GPL-3.0-or-later
"""A part of a scan, cut out before anything is computed on the rest."""

from __future__ import annotations

from ...scan.clipping import crop_pixels


def part(
    crop_m: tuple[float, float, float, float], shape: tuple[int, int], size_m: tuple[float, float]
) -> tuple[tuple[slice, slice], dict]:
    """Rows and columns of a crop, and the step for the processing list.

    Parameters
    ----------
    crop_m
        Left, right, bottom, top in metres from the left and from the bottom.
    shape, size_m
        Of the whole scan: rows and columns, side lengths along x and y in metres.

    Raises
    ------
    ParameterError
        If fewer than 2 x 2 pixels are left.
    """
    rows, cols = shape
    left, right = crop_pixels(crop_m[:2], size_m[0] / cols, cols, "x")
    bottom, top = crop_pixels(crop_m[2:], size_m[1] / rows, rows, "y")
    step = {"step": "crop", "cols": [left, right], "rows": [bottom, top]}
    return (slice(bottom, top), slice(left, right)), step
