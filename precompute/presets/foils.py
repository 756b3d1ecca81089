# SPDX-License-Identifier: GPL-3.0-or-later
"""Holographic foil and brushed metal."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .preset import NM, UM, Parameter, Preset, seed
from .randomness import smooth_field


def _foil(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    period, amplitude = values["period_um"] * UM, values["amplitude_nm"] * NM
    angle = np.radians(values["crossing_deg"])
    second = np.cos(angle) * x[None, :] + np.sin(angle) * y[:, None]
    return amplitude * (np.sin(2.0 * np.pi * x / period)[None, :] + np.sin(2.0 * np.pi * second / period))


#: Standard deviation of the Gaussian that the waves of a grain's edges fade with, in their periods.
_IN_STEP = 2.0


def _brushed(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    rng = np.random.default_rng(int(values["seed"]))
    width, length = values["scratch_width_um"] * UM, values["scratch_length_um"] * UM
    # Scratches of several widths: the finest carry the least height.
    parts = [(0.4, 1.0), (0.7, 3.0), (1.0, 8.0)]
    result = sum(share * smooth_field(rng, x, y, size, width * wide / 4.0, length / 2.0) for share, wide in parts)
    result = values["rms_nm"] * NM * result / np.sqrt(sum(share**2 for share, _ in parts))
    edges, height = values["edges_um"] * UM, values["edges_rms_nm"] * NM
    if height > 0.0:
        # The edges of a grain cut some grooves side by side: waves of one period, in step over a few of them.
        turn = 2.0 * np.pi * x / edges
        waves = [
            wave[None, :] * smooth_field(rng, x, y, size, _IN_STEP * edges, length / 2.0)
            for wave in (np.cos(turn), np.sin(turn))
        ]
        result += height * sum(waves)
    return result


PRESETS = (
    Preset(
        "foil",
        "Holographic Foil",
        "Two crossed sinusoidal gratings, as on wrapping paper and security labels.",
        "R. van Renesse, Optical Document Security: embossed gratings of about 1000 lines/mm; two of them at right "
        "angles.",
        40.0,
        512,
        _foil,
        (
            Parameter("period_um", 1.0, "um", 0.2, 20.0, "Period of both gratings"),
            Parameter("amplitude_nm", 50.0, "nm", 0.0, 1000.0, "Amplitude of each grating"),
            Parameter("crossing_deg", 90.0, "deg", 0.0, 180.0, "Angle from the first grating to the second"),
        ),
    ),
    Preset(
        "brushed_metal",
        "Brushed Metal",
        "Fine scratches along y: a broad streak of light across them with faint colours.",
        "EN 10088-2, finishes 2J and 2K: brushed steel with a roughness of 0.1 to 0.5 um across the scratches; "
        "here its fine end. Edges of a grain: single scratches show colours of their own, Werner, Velinov, Jakob and "
        "Hullin, Scratch Iridescence, ACM TOG 36 (2017) 207.",
        65.0,
        1024,
        _brushed,
        (
            Parameter("scratch_width_um", 0.8, "um", 0.2, 20.0, "Width of the finest scratches"),
            Parameter("scratch_length_um", 60.0, "um", 2.0, 1000.0, "Length of a scratch"),
            Parameter("rms_nm", 100.0, "nm", 0.0, 1000.0, "Standard deviation of the heights"),
            Parameter("edges_um", 1.5, "um", 0.2, 20.0, "Distance of grooves that one grain cuts side by side"),
            Parameter("edges_rms_nm", 0.0, "nm", 0.0, 500.0, "Standard deviation of their heights; 0: none"),
            seed("another piece"),
        ),
    ),
)
