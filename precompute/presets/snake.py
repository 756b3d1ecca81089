# SPDX-License-Identifier: GPL-3.0-or-later
"""Shed skin of snakes: rows of fingers on a wavy membrane.

The sunbeam snake's (Xenopeltis unicolor) dimensions are measured on an atomic force micrograph of
65 um: rows 1.50 um apart, fingers 0.50-0.59 um across and free at their upper ends, where the
height falls by some 70 nm; along a finger the height rises from its root to its tip, a sawtooth
across the rows; narrow grooves separate the fingers; the rows wander by a fraction of their
distance, lean, and the whole skin is wavy over tens of micrometres. The corn snake (Elaphe
guttata) has fingers twice as broad, which go on from row to row: one thin rainbow across them, close to the reflection.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from .preset import NM, UM, Parameter, Preset, seed
from .randomness import smooth_field


def _snake(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    rng = np.random.default_rng(int(values["seed"]))
    disorder = values["disorder_percent"] / 100.0
    row_period, finger = values["row_period_um"] * UM, values["finger_um"] * UM
    height = values["height_nm"] * NM

    def field(length_x_um: float, length_y_um: float) -> np.ndarray:
        return smooth_field(rng, x, y, size, length_x_um * UM, length_y_um * UM)

    # Row coordinate: whole numbers are the roots of a row, the fraction runs from root to tip.
    # Lengths below are those of the measured skin, scaled with its rows and fingers.
    unit, unit_x = row_period / (1.5 * UM), finger / (0.56 * UM)
    wander = disorder * unit * (0.62 * UM * field(2.4 * unit, 8.0 * unit) + 0.08 * UM * field(1.0 * unit, 2.0 * unit))
    q = (y[:, None] + wander) / row_period + 1.0
    row = np.floor(q).astype(np.int64)
    row -= row.min()
    along = q - np.floor(q)

    # Finger coordinate: each row has its own phase and pitch, as far as its fingers do not go on from those below;
    # lean shifts a finger's root against its tip.
    rows = int(row.max()) + 1
    aligned = values["alignment_percent"] / 100.0
    free = 1.0 - aligned
    phase = free**2 * rng.uniform(0.0, 1.0, rows)
    pitch = finger * (1.0 + 0.05 * free**2 * disorder * rng.standard_normal(rows))
    lean = free * disorder * 0.14 * field(6.0 * unit_x, 6.0 * unit_x)
    squeeze = disorder * 0.22 * field(1.2 * unit_x, 1.2 * unit * (1.0 + 40.0 * aligned))
    p = (x[None, :] + lean * row_period * (along - 0.5)) / pitch[row] + phase[row] + squeeze
    column = np.floor(p).astype(np.int64)
    column -= column.min()
    across = p - np.floor(p) - 0.5

    # What differs from finger to finger: where it ends, how high and how broad it is.
    columns = int(column.max()) + 1
    fingers = row * columns + column
    tips = np.clip(0.84 + 0.055 * disorder * rng.standard_normal(rows * columns), 0.6, 0.97)[fingers]
    tips += 0.4 * aligned  # fingers that go on in the next row have no free ends
    heights = np.clip(1.0 + 0.13 * disorder * rng.standard_normal(rows * columns), 0.3, 1.7)[fingers]
    widths = np.clip(0.43 + 0.02 * disorder * rng.standard_normal(rows * columns), 0.33, 0.48)[fingers]

    # Round tip: the outline closes over the last part of the finger as a half ellipse.
    to_tip = (tips - along) / 0.24
    outline = widths * np.sqrt(np.clip(1.0 - (1.0 - np.clip(to_tip, 0.0, 1.0)) ** 2, 0.0, 1.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(outline > 0.0, np.abs(across) / np.maximum(outline, 1e-9), 2.0)
    body = np.where(relative < 1.0, 1.0 - 0.50 * relative**2, 0.0)
    share = np.clip(along / tips, 0.0, 1.0)
    ramp = heights * (1.0 + 0.15 * disorder * field(1.0, 1.0)) * (0.12 + 0.88 * (free * share + aligned))
    # Wedges between the roots: deepest in the lower half, closing towards root and tip.
    grooves = np.clip((np.abs(across) - 0.32) / 0.16, 0.0, 1.0)
    grooves *= free * np.sin(np.pi * share**0.8) * (share < 1.0) + 0.6 * aligned

    result = height * (body * ramp - 0.42 * grooves)
    result += 0.05 * height * disorder * field(0.3, 0.3)
    result = _blurred(result, x, y, 28.0 * NM)
    result += values["waviness_nm"] * NM * field(5.0, 5.0)
    return result - result.mean()


def _blurred(heights: np.ndarray, x: np.ndarray, y: np.ndarray, sigma: float) -> np.ndarray:
    """The rounding of edges by the skin itself and by the microscope's tip."""
    from scipy.ndimage import gaussian_filter

    steps = (y[1] - y[0], x[1] - x[0])
    return gaussian_filter(heights, [sigma / step for step in steps], mode="nearest")


_XENOPELTIS = (
    Parameter("row_period_um", 1.5, "um", 0.5, 10.0, "Distance from row to row along y"),
    Parameter("finger_um", 0.56, "um", 0.1, 5.0, "Distance from finger to finger along x"),
    Parameter("height_nm", 127.0, "nm", 0.0, 1000.0, "Height of the fingers' tips above the membrane"),
    Parameter("waviness_nm", 31.0, "nm", 0.0, 500.0, "Standard deviation of the skin's long waves"),
    Parameter("disorder_percent", 100.0, "percent", 0.0, 300.0, "Disorder relative to the measured skin"),
    Parameter("alignment_percent", 0.0, "percent", 0.0, 100.0, "How far the fingers of a row continue those below"),
    seed("another piece of skin"),
)
#: Fitted to figures of the 65 um scan: one thin rainbow along x, since its columns go on from row to row.
_ELAPHE = {
    "row_period_um": 3.9,
    "finger_um": 1.06,
    "height_nm": 255.0,
    "waviness_nm": 9.0,
    "disorder_percent": 35.0,
    "alignment_percent": 70.0,
}

PRESETS = (
    Preset(
        "snake",
        "Sunbeam Snake (Xenopeltis)",
        "Rows of fingers on the shed skin of Xenopeltis unicolor, the snake that shines in all colours.",
        "Measured on the 65 um atomic force micrograph of M. Single, Diffraction Shader, 2014 (LANE lab, Geneva): "
        "rows 1.50 um, fingers 0.50-0.59 um, rms about 50 nm.",
        65.0,
        1024,
        _snake,
        _XENOPELTIS,
    ),
    Preset(
        "elaphe",
        "Corn Snake (Elaphe)",
        "Broad fingers that go on from row to row on the shed skin of Elaphe guttata: one thin rainbow across them.",
        "Columns 1.0-1.13 um apart as on the scans of M. Single, Diffraction Shader, 2014 (LANE lab, Geneva); "
        "range of heights 435 nm; rows, heights and alignment are fitted to how the 65 um scan spreads its light.",
        65.0,
        1024,
        _snake,
        tuple(replace(parameter, default=_ELAPHE.get(parameter.name, parameter.default)) for parameter in _XENOPELTIS),
    ),
)
