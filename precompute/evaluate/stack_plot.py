# SPDX-License-Identifier: GPL-3.0-or-later
"""R of a stack over wavelength and angle as a small picture, before any bake."""

from __future__ import annotations

import numpy as np

from ..constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M
from ..light.colour import encode_srgb, into_gamut, luminance_row, spectral_weights, xyz_to_rgb
from ..stack import Material, Stack
from .stack_colour import stack_rgb

#: Rows and columns of the strips beside the map: colours of the wavelengths below, of the mirror on the right.
_STRIP, _GAP = 10, 3

#: Lines over the map.
LINES_NM, LINES_DEG = (400, 500, 600, 700), (30, 60)


def stack_plot(
    stack: Stack, outer: Material | None = None, width: int = 200, height: int = 130
) -> tuple[np.ndarray, float, float]:
    """Draw R over the wavelength (380 to 780 nm, to the right) and the angle (0 to 90 degrees, upwards).

    The map's grey is R, black for 0 and white for the largest. Below it stand the colours of the wavelengths, on its
    right those that a flat mirror shows in daylight at each angle.

    Parameters
    ----------
    stack
        Films and substrate.
    outer
        What the light comes from; None is air. Angles count there.
    width, height
        Of the picture in pixels.

    Returns
    -------
    picture : ndarray
        ``(height, width, 3)`` sRGB in 0..1, row 0 at the bottom.
    least, largest : float
        R of the map.
    """
    columns, rows = width - _STRIP - _GAP, height - _STRIP - _GAP
    lam = WAVELENGTH_MIN_M + (WAVELENGTH_MAX_M - WAVELENGTH_MIN_M) * (np.arange(columns) + 0.5) / columns
    angle = 0.5 * np.pi * (np.arange(rows) + 0.5) / rows
    r = stack.reflectance(lam, np.cos(angle), outer).T
    picture = np.full((height, width, 3), 0.12)
    shown = encode_srgb(r / r.max())[..., None] * np.ones(3)
    for nm in LINES_NM:
        column = int((nm * 1e-9 - WAVELENGTH_MIN_M) / (WAVELENGTH_MAX_M - WAVELENGTH_MIN_M) * columns)
        shown[:, column] = 0.7 * shown[:, column] + 0.3 * np.array((0.2, 0.5, 0.9))
    for degrees in LINES_DEG:
        row = int(degrees / 90.0 * rows)
        shown[row] = 0.7 * shown[row] + 0.3 * np.array((0.2, 0.5, 0.9))
    picture[height - rows :, :columns] = shown
    picture[:_STRIP, :columns] = _rainbow(lam)
    picture[height - rows :, width - _STRIP :] = encode_srgb(stack_rgb(stack, np.cos(angle), outer=outer))[:, None]
    return picture, float(r.min()), float(r.max())


def _rainbow(wavelengths_m: np.ndarray) -> np.ndarray:
    """``(L, 3)`` sRGB of single wavelengths, within the gamut and of one brightness apart from the ends' dimness."""
    lam, weights = spectral_weights(illuminant="E")
    xyz = np.stack([np.interp(wavelengths_m, lam, weights[:, c]) for c in range(3)], -1)
    rgb = into_gamut(xyz_to_rgb(xyz), luminance_row())
    peak = rgb.max(axis=-1, keepdims=True)
    return encode_srgb(rgb / np.maximum(peak, 0.15 * peak.max()))
