# SPDX-License-Identifier: GPL-3.0-or-later
"""T(u, v, w) of a small patch as the definitions say it, sample by sample; shares no code with the project.

Heights are ``(rows, cols)``, row 0 at the bottom; lengths in metres; ``(u, v, w) = -(wi + wr)``.
"""

from __future__ import annotations

import numpy as np


def _samples(heights, dx, dy, u, v, w, wavelength):
    """Pixel centres, and p exp(i k (u x + v y)) there."""
    rows, cols = heights.shape
    x = (np.arange(cols) + 0.5) * dx
    y = (np.arange(rows) + 0.5) * dy
    k = 2 * np.pi / wavelength
    wave = np.exp(1j * k * (w * heights + u * x[None, :] + v * y[:, None]))
    return x, y, wave


def single(heights, dx, dy, sigma, u, v, w, wavelength):
    """|P|^2 / (A lambda^2) with one Gaussian window in the middle of the patch."""
    x, y, wave = _samples(heights, dx, dy, u, v, w, wavelength)
    middle_x, middle_y = 0.5 * heights.shape[1] * dx, 0.5 * heights.shape[0] * dy
    g = np.exp(-((x[None, :] - middle_x) ** 2 + (y[:, None] - middle_y) ** 2) / (2 * sigma**2))
    P = (g * wave).sum() * dx * dy
    A = (g**2).sum() * dx * dy
    return abs(P) ** 2 / (A * wavelength**2)


def average(heights, dx, dy, sigma, u, v, w, wavelength):
    """Mean of |P|^2 of the tapered patch over window centres at every pixel and 6 sigma beyond the patch."""
    from scipy.signal.windows import tukey

    rows, cols = heights.shape
    x, y, wave = _samples(heights, dx, dy, u, v, w, wavelength)
    t = tukey(rows, 0.2)[:, None] * tukey(cols, 0.2)[None, :]
    beyond_x, beyond_y = int(np.ceil(6 * sigma / dx)), int(np.ceil(6 * sigma / dy))
    power = norm = 0.0
    for centre_y in (np.arange(-beyond_y, rows + beyond_y) + 0.5) * dy:
        gy = np.exp(-((y - centre_y) ** 2) / (2 * sigma**2))[:, None]
        for centre_x in (np.arange(-beyond_x, cols + beyond_x) + 0.5) * dx:
            g = gy * np.exp(-((x - centre_x) ** 2) / (2 * sigma**2))[None, :]
            power += abs((t * g * wave).sum() * dx * dy) ** 2
            norm += ((t * g) ** 2).sum() * dx * dy
    return power / (norm * wavelength**2)


ENSEMBLES = {"single": single, "average": average}
