# SPDX-License-Identifier: GPL-3.0-or-later
"""Seeded disorder that does not depend on the pixel count."""

from __future__ import annotations

import numpy as np


def smooth_field(
    rng: np.random.Generator,
    x: np.ndarray,
    y: np.ndarray,
    size: tuple[float, float],
    length_x: float,
    length_y: float,
) -> np.ndarray:
    """A Gaussian random field with mean 0 and standard deviation 1 on the grid of ``x`` and ``y``.

    White noise on a grid of a third of the correlation lengths, smoothed and normalised by the
    filter's own norm, then interpolated: finer pixels show the same field in more detail.

    Parameters
    ----------
    rng
        Source of randomness; takes the same draws whatever the pixel count.
    x, y
        Pixel centres in metres.
    size
        Side lengths of the patch in metres.
    length_x, length_y
        Standard deviation of the smoothing Gaussian along x and y, metres.
    """
    from scipy.interpolate import RectBivariateSpline
    from scipy.ndimage import gaussian_filter1d

    sigma, margin = 3.0, 12
    step_x, step_y = length_x / sigma, length_y / sigma
    cols, rows = int(np.ceil(size[0] / step_x)) + 1, int(np.ceil(size[1] / step_y)) + 1
    noise = rng.standard_normal((rows + 2 * margin, cols + 2 * margin))
    # The variance of smoothed white noise is the sum of the squared filter weights, 1/(2 sqrt(pi) sigma) an axis.
    for axis in (0, 1):
        noise = gaussian_filter1d(noise, sigma, axis=axis, mode="constant") * np.sqrt(2.0 * np.sqrt(np.pi) * sigma)
    field = noise[margin:-margin, margin:-margin]
    order = min(3, rows - 1, cols - 1)
    spline = RectBivariateSpline(np.arange(rows) * step_y, np.arange(cols) * step_x, field, kx=order, ky=order)
    return spline(y, x)
