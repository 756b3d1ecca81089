# SPDX-License-Identifier: GPL-3.0-or-later
"""Random bumps after Stam (Diffraction Shaders, SIGGRAPH 1999): equal bumps at independent places."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .preset import NM, UM, Parameter, Preset, seed


def _bumps(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    rng = np.random.default_rng(int(values["seed"]))
    radius_x, radius_y = values["length_um"] * UM / 2.0, values["width_um"] * UM / 2.0
    height = values["height_nm"] * NM
    # Bumps outside reach in; drawing them too keeps the field's statistics up to the edge.
    area = (size[0] + 2 * radius_x) * (size[1] + 2 * radius_y)
    count = int(rng.poisson(values["density_per_um2"] * area / UM**2))
    centres_x = rng.uniform(-radius_x, size[0] + radius_x, count)
    centres_y = rng.uniform(-radius_y, size[1] + radius_y, count)
    result = np.zeros((y.size, x.size))
    for cx, cy in zip(centres_x, centres_y, strict=True):
        left, right = np.searchsorted(x, (cx - radius_x, cx + radius_x))
        low, high = np.searchsorted(y, (cy - radius_y, cy + radius_y))
        squared = ((x[left:right] - cx) / radius_x)[None, :] ** 2 + ((y[low:high] - cy) / radius_y)[:, None] ** 2
        # A smooth bump with compact support, like Stam's: no edge, no plateau.
        result[low:high, left:right] += height * np.clip(1.0 - squared, 0.0, None) ** 2
    return result


PRESETS = (
    Preset(
        "stam_bumps",
        "Random Bumps (Stam)",
        "Equal bumps strewn at random: a halo of colour round the reflection.",
        "J. Stam, Diffraction Shaders, SIGGRAPH 1999: a surface of randomly distributed identical bumps, 150 nm high.",
        65.0,
        1024,
        _bumps,
        (
            Parameter("length_um", 2.0, "um", 0.2, 50.0, "Size of a bump along x"),
            Parameter("width_um", 2.0, "um", 0.2, 50.0, "Size of a bump along y"),
            Parameter("height_nm", 150.0, "nm", -2000.0, 2000.0, "Height of a bump; negative ones are pits"),
            Parameter("density_per_um2", 0.2, "per_um2", 0.0, 2.0, "Bumps a square micrometre"),
            seed("other places"),
        ),
    ),
)
