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

#: Lines over the map, which their numbers stand beside.
LINES_NM, LINES_DEG = (400, 500, 600, 700), (30, 60)

#: Digits of three columns and five rows, from the top, a row's bits from the left.
_DIGITS = {
    "0": (7, 5, 5, 5, 7), "3": (7, 1, 7, 1, 7), "4": (5, 5, 7, 1, 1), "5": (7, 4, 7, 1, 7), "6": (7, 4, 7, 5, 7),
    "7": (7, 1, 1, 1, 1),
}  # fmt: skip

#: Colours of the lines and of the numbers.
_LINE, _NUMBER = np.array((0.2, 0.5, 0.9)), np.array((0.1, 0.35, 0.8))


def stack_plot(
    stack: Stack, outer: Material | None = None, width: int = 220, height: int = 220
) -> tuple[np.ndarray, float, float]:
    """Draw R over the wavelength (380 to 780 nm, to the right) and the angle (0 to 90 degrees, upwards).

    The map's grey is R, black for 0 and white for the largest. Below it stand the colours of the wavelengths, on its
    right those that a flat mirror shows in daylight at each angle. Lines carry their nanometres and degrees.

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
    size = max(1, width // 110)
    for nm in LINES_NM:
        column = int((nm * 1e-9 - WAVELENGTH_MIN_M) / (WAVELENGTH_MAX_M - WAVELENGTH_MIN_M) * columns)
        shown[:, column] = 0.7 * shown[:, column] + 0.3 * _LINE
        _write(shown, str(nm), column + 2 * size, rows - 8 * size, size)
    for degrees in LINES_DEG:
        row = int(degrees / 90.0 * rows)
        shown[row] = 0.7 * shown[row] + 0.3 * _LINE
        _write(shown, str(degrees), 2 * size, row + 2 * size, size)
    picture[height - rows :, :columns] = shown
    picture[:_STRIP, :columns] = _rainbow(lam)
    picture[height - rows :, width - _STRIP :] = encode_srgb(stack_rgb(stack, np.cos(angle), outer=outer))[:, None]
    return picture, float(r.min()), float(r.max())


def _write(picture: np.ndarray, digits: str, column: int, row: int, size: int) -> None:
    """A number into a picture, its lower left corner at a column and a row; what passes the right edge is left out."""
    for place, digit in enumerate(digits):
        left = column + 4 * size * place
        if left + 3 * size > picture.shape[1]:
            return
        bits = np.array([[line >> shift & 1 for shift in (2, 1, 0)] for line in reversed(_DIGITS[digit])], bool)
        where = np.kron(bits, np.ones((size, size), bool))
        picture[row : row + 5 * size, left : left + 3 * size][where] = _NUMBER


def _rainbow(wavelengths_m: np.ndarray) -> np.ndarray:
    """``(L, 3)`` sRGB of single wavelengths, within the gamut and of one brightness apart from the ends' dimness."""
    lam, weights = spectral_weights(illuminant="E")
    xyz = np.stack([np.interp(wavelengths_m, lam, weights[:, c]) for c in range(3)], -1)
    rgb = into_gamut(xyz_to_rgb(xyz), luminance_row())
    peak = rgb.max(axis=-1, keepdims=True)
    return encode_srgb(rgb / np.maximum(peak, 0.15 * peak.max()))
