# SPDX-License-Identifier: GPL-3.0-or-later
"""Recipes that send light to a place: a lens, two pictures for two eyes.

With the light at ``wi`` and the viewer at ``wr`` order 1 of wavelength lambda shines where the grating vector is
``K = lambda / p (cos phi, sin phi) = -(wi + wr)_xy`` or its opposite (the grating equation).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import ParameterError
from .cells import luminance
from .recipe import Maps, Plane, Recipe, Setting


def _lens(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """A Fresnel zone lens: at the distance r from the middle the period lambda sqrt(r^2 + f^2) / r sends light that
    falls straight down to the focus. Near the middle the period passes the table's own: nothing stands there."""
    wavelength = values["wavelength_nm"] * 1e-9
    r = np.hypot(plane.x, plane.y) * 0.5 * plane.size_m
    focus = values["focus_mm"] * 1e-3
    sine = r / np.hypot(r, focus)
    scale = wavelength / plane.period_m / np.maximum(sine, 1e-12)
    there = scale <= values["headroom"]
    return {
        "rotation": np.arctan2(plane.y, plane.x),
        "scale": np.where(there, scale, values["headroom"]),
        "mask": there.astype(np.float32),
        "info": {"without_structure": float(1.0 - there.mean())},
    }


def _stereo(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """Two pictures in turn, column by column: the left eye sees one, the right eye the other.

    The eyes stand at +-angle to the left and right of the normal, the lamp above, in the plane of y and normal.
    """
    eye, lamp = np.radians(values["eye_deg"]), np.radians(values["lamp_deg"])
    wavelength = values["wavelength_nm"] * 1e-9
    u, v = np.sin(eye), -np.sin(lamp)  # -(wi + wr)_xy of the left eye, which stands at -x
    length = float(np.hypot(u, v))
    if length == 0.0:
        raise ParameterError("Eyes and lamp stand on the normal: raise --lamp-deg or --eye-deg.")
    scale = wavelength / (plane.period_m * length)
    if scale > values["headroom"]:
        raise ParameterError(
            f"The period for {values['wavelength_nm']:g} nm would be {scale:.2f} times the table's; give a larger lamp "
            "angle, a shorter wavelength, a table of a larger period, or headroom."
        )
    column = np.broadcast_to(np.arange(plane.shape[1]) % 2, plane.shape).astype(bool)
    angle = np.arctan2(v, u)
    shown = np.where(column, luminance(pictures[1]), luminance(pictures[0]))
    return {
        "rotation": np.where(column, np.pi - angle, angle),  # the right eye's K has the opposite x
        "scale": np.full(plane.shape, scale),
        "mask": np.clip(shown, 0.0, 1.0),
    }


_WAVELENGTH = Setting("wavelength_nm", 550.0, 380.0, 780.0, "The wavelength that it is made for, nanometres")
_HEADROOM = Setting("headroom", 1.0, 0.05, 8.0, "Largest period that the table holds, over its own")

RECIPES = (
    Recipe(
        "lens", "Lens", "A Fresnel zone lens: a spot of light that floats before or behind the surface.", _lens,
        (Setting("focus_mm", 60.0, 0.001, 100000.0, "Focal length, millimetres"), _WAVELENGTH, _HEADROOM),
    ),
    Recipe(
        "stereo", "Stereo", "Two pictures, one for each eye, under a lamp above.", _stereo,
        (
            Setting("eye_deg", 6.0, 0.0, 45.0, "Angle of each eye from the normal, degrees"),
            Setting("lamp_deg", 35.0, 1.0, 85.0, "Angle of the lamp above the normal, degrees"),
            _WAVELENGTH, _HEADROOM,
        ),
        pictures=2,
    ),
)  # fmt: skip
