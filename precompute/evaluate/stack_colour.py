# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of a mirror of some stuff, before any bake."""

from __future__ import annotations

import numpy as np

from ..light.colour import adaptation, into_gamut, luminance_row, spectral_weights, xyz_to_rgb
from ..light.illuminant import Illuminant
from ..stack import Material, Stack


def stack_xyz(
    stack: Stack, cos_theta: np.ndarray, illuminant: Illuminant = "D65", outer: Material | None = None
) -> np.ndarray:
    """XYZ of a flat mirror, white 1, adapted to D65 where the light can be white.

    Parameters
    ----------
    stack
        Films and substrate.
    cos_theta
        Cosines in the outer medium, any shape.
    illuminant
        The light.
    outer
        What the light comes from; None is air.

    Returns
    -------
    ndarray
        ``(..., 3)``.
    """
    wavelengths, weights = spectral_weights(illuminant=illuminant)
    xyz = np.moveaxis(stack.reflectance(wavelengths, cos_theta, outer), 0, -1) @ weights
    to_adapted = adaptation(illuminant)
    return xyz if to_adapted is None else xyz @ to_adapted.T


def stack_rgb(
    stack: Stack, cos_theta: np.ndarray, illuminant: Illuminant = "D65", outer: Material | None = None
) -> np.ndarray:
    """The same as linear Rec.709, within its gamut."""
    return into_gamut(xyz_to_rgb(stack_xyz(stack, cos_theta, illuminant, outer)), luminance_row())
