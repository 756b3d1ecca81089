# SPDX-License-Identifier: GPL-3.0-or-later
"""Ridges of a Morpho butterfly's scale, as far as a heightfield can show them.

The scale carries parallel ridges; each is a stack of tilted lamellae whose edges come to the
ridge's top one after the other, and the ridges' heights are irregular, which spreads the colour
over directions (Kinoshita, Yoshioka and Kawagoe, Proc. R. Soc. B 269, 2002). The blue itself is
made by interference *inside* the stack, which no heightfield has. The preset's look adds it as a model: the table's
heights times the reflectance of lamellae as wide as the scale (`looks.py`).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .preset import NM, UM, Parameter, Preset, seed


def _morpho(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    rng = np.random.default_rng(int(values["seed"]))
    period, width = values["ridge_period_um"] * UM, values["ridge_width_um"] * UM
    step, length = values["lamella_nm"] * NM, values["lamella_length_um"] * UM
    ridge = np.floor(x / period).astype(np.int64)
    across = np.abs(x - (ridge + 0.5) * period)
    profile = np.clip((width / 2.0 - across) / (0.25 * width) + 0.5, 0.0, 1.0)
    top = np.empty((y.size, x.size))
    count = int(np.ceil(size[1] / (0.5 * length))) + 3
    for number in range(int(ridge.max()) + 1):
        # A lamella rises along y and ends in a step, where the next one below comes to the top.
        lengths = length * rng.uniform(0.5, 1.5, count)
        ends = np.cumsum(lengths) - lengths[0] * rng.uniform(0.0, 1.0)
        lamella = np.searchsorted(ends, y)
        share = 1.0 - (ends[lamella] - y) / lengths[lamella]
        # Heights of ridges and lamellae vary by a lamella or more, so that their phases are unrelated.
        heights = rng.uniform(0.0, 1.0) + 0.25 * rng.uniform(-1.0, 1.0, count)
        top[:, ridge == number] = (step * share + values["irregularity_nm"] * NM * heights[lamella])[:, None]
    return profile[None, :] * (top + 2.0 * step)


PRESETS = (
    Preset(
        "morpho",
        "Morpho Ridges",
        "Ridges of a Morpho butterfly's scale over a stack of lamellae; the heights alone hold no blue, the look's "
        "stack does.",
        "Kinoshita, Yoshioka and Kawagoe, Proc. R. Soc. B 269 (2002) 1417: ridges 0.7 um apart and 0.3 um broad, "
        "lamellae 0.2 um apart and tilted, irregular heights.",
        40.0,
        512,
        _morpho,
        (
            Parameter("ridge_period_um", 0.7, "um", 0.2, 10.0, "Distance from ridge to ridge along x"),
            Parameter("ridge_width_um", 0.3, "um", 0.05, 5.0, "Width of a ridge"),
            Parameter("lamella_nm", 200.0, "nm", 0.0, 1000.0, "Height from one lamella to the next"),
            Parameter("lamella_length_um", 2.0, "um", 0.2, 50.0, "Visible length of a lamella along y"),
            Parameter("irregularity_nm", 200.0, "nm", 0.0, 2000.0, "Spread of the ridges' heights"),
            seed("another scale"),
        ),
    ),
)
