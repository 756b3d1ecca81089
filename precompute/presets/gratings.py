# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat plate, sinusoidal and blazed grating: structures whose diffraction is known in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .preset import NM, UM, Parameter, Preset


def _flat(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    return np.zeros((y.size, x.size))


def _sinusoid(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    line = values["amplitude_nm"] * NM * np.sin(2.0 * np.pi * x / (values["period_um"] * UM))
    return np.tile(line, (y.size, 1))


def _blazed(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    phase = x / (values["period_um"] * UM)
    # A pixel centre that should lie on a groove's edge must not fall to its far side by rounding.
    line = values["depth_nm"] * NM * np.mod(np.round(phase, 9), 1.0)
    if values["mirror"]:
        line = line[::-1]
    return np.tile(line, (y.size, 1))


PRESETS = (
    Preset(
        "flat",
        "Flat Plate",
        "A perfect mirror: it must show its reflection and nothing else.",
        "Definition.",
        40.0,
        512,
        _flat,
    ),
    Preset(
        "sinusoid",
        "Sinusoidal Grating",
        "A holographic grating; order m takes the part J_m(k w a)^2 of the light.",
        "Palmer, Diffraction Grating Handbook: holographic gratings record the near-sinusoidal fringes of two beams.",
        40.0,
        512,
        _sinusoid,
        (
            Parameter("period_um", 2.0, "um", 0.1, 1000.0, "Distance from crest to crest along x"),
            Parameter("amplitude_nm", 50.0, "nm", 0.0, 5000.0, "Half the height from trough to crest"),
        ),
    ),
    Preset(
        "blazed",
        "Blazed Grating",
        "A ruled sawtooth grating, 400 grooves a millimetre, that throws most light to one side.",
        "Palmer, Diffraction Grating Handbook: ruled plane gratings, 400 grooves/mm = 2.5 um; first-order blaze at "
        "normal incidence near twice the depth.",
        40.0,
        512,
        _blazed,
        (
            Parameter("period_um", 2.5, "um", 0.1, 1000.0, "Distance from groove to groove along x"),
            Parameter("depth_nm", 275.0, "nm", 0.0, 5000.0, "Height of the sawtooth, h = depth * frac(x / period)"),
            Parameter("mirror", False, "", None, None, "Reverse left and right"),
        ),
    ),
)
