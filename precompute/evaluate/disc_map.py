# SPDX-License-Identifier: GPL-3.0-or-later
"""BRDF maps: all view directions of one light direction as a picture.

The hemisphere is seen from above, orthographically: the pixel at (x, y) of the unit disc shows
``wr = (x, y, sqrt(1 - x^2 - y^2))``, x to the right, y up. The mirror direction of a light at (x, y) lies at (-x, -y).
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from ..errors import ParameterError
from ..files.images import check_image_path, write_exr, write_png
from ..light.colour import encode_srgb, into_gamut, luminance_row, xyz_to_rgb
from ..light.illuminant import Illuminant
from .directions import disc_directions
from .surface import Transform, brdf

#: Part of the disc that a picture may show at full brightness; the specular peak is a thousand times brighter.
_WHITE_PART = 0.02

#: Rows evaluated at a time, which bounds the memory of a large map.
_BLOCK_ROWS = 64


def check_size(size: int) -> int:
    """A usable number of pixels a side, or ParameterError."""
    if not 2 <= size <= 8192:
        raise ParameterError(f"A map of {size} pixels a side makes no sense; give 2 to 8192.")
    return int(size)


def brdf_map(
    table: Transform,
    wi: np.ndarray,
    size: int = 512,
    fresnel: complex | None = None,
    energy_conserving: bool = False,
    form: str = "schlick",
) -> np.ndarray:
    """The absolute BRDF of a table towards every view direction.

    Parameters
    ----------
    table
        A `precompute.table.table.SpectralTable`.
    wi
        ``(3,)`` unit vector towards the light.
    size
        Pixels a side.
    fresnel, energy_conserving, form
        As in `precompute.evaluate.surface.brdf`.

    Returns
    -------
    ndarray
        ``(size, size, 3)`` XYZ in 1/sr, row 0 at the bottom; 0 outside the disc.
    """
    directions, inside = disc_directions(check_size(size))
    xyz = np.zeros((size, size, 3))

    def fill(start: int) -> None:
        rows = slice(start, start + _BLOCK_ROWS)
        here = inside[rows]
        xyz[rows][here] = brdf(table, wi, directions[rows][here], fresnel, energy_conserving, form)

    with ThreadPoolExecutor(min(os.cpu_count() or 1, 8)) as pool:
        list(pool.map(fill, range(0, size, _BLOCK_ROWS)))
    return xyz


def exposure_of(xyz: np.ndarray, illuminant: Illuminant = "D65") -> float:
    """Factor that shows 2 % of a map's disc at full brightness, so that the orders are visible beside the peak."""
    brightest = xyz_to_rgb(xyz, illuminant=illuminant).max(axis=-1)
    brightest = brightest[brightest > 0]
    if not brightest.size:
        return 1.0
    place = brightest.size - 1 - int(_WHITE_PART * (brightest.size - 1))
    return float(1.0 / np.partition(brightest, place)[place])


def map_to_srgb(xyz: np.ndarray, exposure: float | None = None, illuminant: Illuminant = "D65") -> np.ndarray:
    """Display values of a map.

    Colours outside the gamut move towards grey; colours brighter than the display keep their hue and
    saturation and lose brightness.

    Parameters
    ----------
    xyz
        ``(..., 3)``.
    exposure
        Factor on the linear values; None takes `exposure_of`.

    Returns
    -------
    ndarray
        ``(..., 3)`` sRGB in 0..1.
    """
    factor = exposure_of(xyz, illuminant) if exposure is None else exposure
    rgb = into_gamut(factor * xyz_to_rgb(xyz, illuminant=illuminant), luminance_row(illuminant=illuminant))
    return encode_srgb(rgb / np.maximum(1.0, rgb.max(axis=-1, keepdims=True)))


def direction_grid(size: int) -> np.ndarray:
    """Circles at polar angles of 30, 60 and 90 degrees and spokes every 30 degrees of azimuth.

    Parameters
    ----------
    size
        Pixels a side of the map.

    Returns
    -------
    ndarray
        ``(size, size)`` coverage of the lines, one pixel wide, in 0..1.
    """
    axis = np.arange(size) + 0.5 - 0.5 * size
    x, y = np.meshgrid(axis, axis)
    radius, rim = np.hypot(x, y), 0.5 * size
    coverage = np.zeros((size, size))
    for degrees in (30, 60, 90):
        away = np.abs(radius - min(rim * np.sin(np.radians(degrees)), rim - 1.0))
        coverage = np.maximum(coverage, np.clip(1.0 - away, 0.0, 1.0))
    for azimuth in np.radians(np.arange(0, 180, 30)):
        away = np.abs(x * np.sin(azimuth) - y * np.cos(azimuth))
        # The middle stays free: spokes start at 15 degrees.
        spoke = np.clip(1.0 - away, 0.0, 1.0) * ((radius > rim * np.sin(np.radians(15))) & (radius < rim))
        coverage = np.maximum(coverage, spoke)
    return coverage


def save_map(
    xyz: np.ndarray,
    path: str | os.PathLike[str],
    exposure: float | None = None,
    illuminant: Illuminant = "D65",
    grid: bool = False,
) -> Path:
    """Write a map: ``.png`` as `map_to_srgb` shows it, ``.exr`` as linear Rec.709, unscaled, f in 1/sr.

    ``grid`` draws `direction_grid` over a ``.png``; an ``.exr`` holds numbers, so it has none.
    """
    path = check_image_path(path)
    if path.suffix.lower() == ".png":
        srgb = map_to_srgb(xyz, exposure, illuminant)
        if grid:
            lines = 0.45 * direction_grid(len(srgb))[..., None]
            srgb = srgb * (1.0 - lines) + lines
        return write_png(path, srgb)
    return write_exr(path, xyz_to_rgb(xyz, illuminant=illuminant))
