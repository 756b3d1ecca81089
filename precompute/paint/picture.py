# SPDX-License-Identifier: GPL-3.0-or-later
"""The recipe `picture`: paint in the colours that shall be seen.

Hue becomes the period that shows it, brightness the depth, under one lamp and from one direction, both in the plane of
x and normal: order m of wavelength lambda shines where ``m lambda = p (sin lamp + sin view)``.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import ParameterError
from .cells import luminance
from .hue import dominant_wavelength, order_hues
from .recipe import Maps, Plane, Recipe, Setting


def _picture(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    rgb = np.clip(pictures[0], 0.0, None)
    sines = np.sin(np.radians(values["lamp_deg"])) + np.sin(np.radians(values["view_deg"]))
    if abs(sines) < 1e-3:
        raise ParameterError("Lamp and viewer stand mirror-like to the normal, where all hues meet; move one of them.")
    wavelength, saturation = dominant_wavelength(rgb)
    bright = luminance(rgb)
    lit = bright > values["darkest"]
    grey = saturation < values["least_saturation"]
    purple = ~np.isfinite(wavelength)
    scales, hues = order_hues(abs(sines), plane.period_m, values["sigma_s_um"] * 1e-6, values["headroom"])
    known = np.where(purple, hues[0], wavelength)
    # The band that a finite coherence window lets through pulls the ends of the spectrum inwards.
    band = ~purple & ~grey & ((known < hues[0]) | (known > hues[-1]))
    large = band & (known > hues[-1]) & (known > abs(sines) * plane.period_m * values["headroom"])
    scale = np.interp(known, hues, scales)
    there = lit & ~grey & ~purple & ~band
    outside = {
        "grey": float((lit & grey).mean()),
        "purple": float((lit & purple & ~grey).mean()),
        "period_too_large": float((lit & large).mean()),
        "band_too_wide": float((lit & band & ~large).mean()),
    }
    if not there.any():
        raise ParameterError(
            "No hue of the picture can be shown: greys and purples have no wavelength of their own, and the period for "
            f"the rest passes {values['headroom']:g} times the table's; choose another lamp angle or a larger period."
        )
    # Of a relief that is shallow beside the wavelength, order 1 takes a part that grows with the square of its depth.
    top = float(np.quantile(bright[there], 0.999))
    return {
        "scale": np.where(there, scale, values["headroom"]),
        "depth": np.sqrt(np.clip(bright / top, 0.0, 1.0)),
        "mask": there.astype(np.float32),
        "info": {"marked": outside},
    }


RECIPES = (
    Recipe(
        "picture", "Picture", "A picture in the colours that it shall show under one lamp.", _picture,
        (
            Setting("lamp_deg", 35.0, -85.0, 85.0, "Angle of the lamp from the normal towards x, degrees"),
            Setting("view_deg", 0.0, -85.0, 85.0, "Angle of the viewer from the normal towards x, degrees"),
            Setting("sigma_s_um", 16.25, 0.1, 1000.0, "The table's coherence width, which makes the band of an order"),
            Setting("least_saturation", 0.15, 0.0, 1.0, "What is greyer stays without structure"),
            Setting("darkest", 0.004, 0.0, 1.0, "What is darker stays without structure"),
            Setting("headroom", 1.0, 0.05, 8.0, "Largest period that the table holds, over its own"),
        ),
        pictures=1,
    ),
)  # fmt: skip
