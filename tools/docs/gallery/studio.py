# SPDX-License-Identifier: GPL-3.0-or-later
"""A photographer's studio as an environment picture: three softboxes in a nearly black room."""

from __future__ import annotations

import numpy as np

#: Softboxes: direction to the middle, width and height (radians), strength (W / m^2 / sr), RGB.
BOXES = (
    ((-0.10, 0.75, 0.65), (1.10, 0.30), 9.0, (1.00, 0.97, 0.93)),
    ((-0.88, 0.25, 0.40), (0.30, 0.80), 9.0, (0.86, 0.93, 1.00)),
    ((0.90, 0.05, 0.44), (0.30, 0.80), 8.0, (1.00, 0.94, 0.86)),
)

#: Radiance of the room from floor to ceiling.
FLOOR, CEILING = (0.004, 0.004, 0.005), (0.030, 0.034, 0.042)


def studio(width=2048):
    """``(width / 2, width, 3)`` radiance, top row first, in the layout of Blender's Environment Texture."""
    height = width // 2
    azimuth = np.pi - 2.0 * np.pi * (np.arange(width) + 0.5) / width
    elevation = 0.5 * np.pi - np.pi * (np.arange(height) + 0.5) / height
    azimuth, elevation = np.meshgrid(azimuth, elevation)
    direction = np.stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], -1
    )
    rise = np.clip(0.5 + 0.5 * direction[..., 2:], 0.0, 1.0) ** 2
    picture = (1.0 - rise) * FLOOR + rise * CEILING
    for centre, (across, up), strength, colour in BOXES:
        centre = np.array(centre) / np.linalg.norm(centre)
        right = np.cross((0.0, 0.0, 1.0), centre)
        right /= np.linalg.norm(right)
        depth = direction @ centre
        ahead = np.maximum(depth, 1e-6)
        x, y = np.abs(direction @ right) / ahead, np.abs(direction @ np.cross(centre, right)) / ahead
        inside = _edge(x, 0.5 * across) * _edge(y, 0.5 * up) * (depth > 0.0)
        picture = picture + strength * inside[..., None] * np.array(colour)
    return picture.astype(np.float32)


def _edge(distance, half, soft=0.25):
    """1 inside, 0 outside, smooth over a quarter of the half width."""
    t = np.clip((half * (1.0 + soft) - distance) / (2.0 * soft * half), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def save(path):
    """Write the picture as EXR."""
    import OpenEXR

    path.parent.mkdir(parents=True, exist_ok=True)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with OpenEXR.File(header, {"RGB": studio()}) as file:
        file.write(str(path))
    return path
