# SPDX-License-Identifier: GPL-3.0-or-later
"""`flss`: the loop of the thesis's shader (wavelengths x Taylor terms x 3 x 3 neighbours), the yardstick.

Terms are single-precision textures of the patch's own DFT bins, as a fragment shader reads them. Two things are
corrected: the window's transform is normalised (eq. 3.30), and the square is taken after the sum (eq. 3.32).
``shaders/flss.glsl`` is the same loop on a GPU, drawn by ``addon/viewport/``.
"""

from __future__ import annotations

import math

import numpy as np

from ...constants import KAPPA_MAX
from ...errors import ParameterError
from ...light.colour import spectral_weights
from ...light.illuminant import Illuminant
from ...scan.heightfield import HeightField
from ...stack import Stack
from ..directions import uvw
from ..surface import cos_half, geometry_factor, relative_factor
from .bins import Band
from .windowed import Windowed

#: Step of the wavelength loop: 79 wavelengths or so, as the thesis has.
STEP_M = 5e-9


def check_single_precision(field: HeightField, tolerance: float) -> None:
    """Refuse a tolerance that the Taylor series cannot reach in float32.

    Its terms grow to e^x, x = kappa_max h_max, each with a rounding error of 2^-24.

    Raises
    ------
    ParameterError
        With the numbers.
    """
    x = KAPPA_MAX * 0.5 * float(np.ptp(field.heights))
    reachable = math.exp(min(x, 80.0)) * 2.0**-24
    if reachable > tolerance:
        raise ParameterError(
            f"Single precision cannot reach the tolerance {tolerance:g}: at kappa h = {x:.1f} the Taylor terms grow to"
            f" {math.exp(min(x, 80.0)):.1e} and leave an error of {reachable:.1e}; level and clip the scan, allow"
            f" {2 * reachable:.0e}, or use the method 'windowed'."
        )


class Flss(Windowed):
    """T by 3 x 3 neighbours of Taylor terms in complex64; see `Windowed` for the parameters."""

    def __init__(self, field: HeightField, sigma_s_m: float, tolerance: float = 1e-2, band: Band | None = None) -> None:
        check_single_precision(field, tolerance)
        super().__init__(field, sigma_s_m, "taylor", tolerance, True, band, np.complex64)

    def xyz(self, wi: np.ndarray, wr: np.ndarray, illuminant: Illuminant = "D65", normalisation: str = "relative"):
        """Colours ``(..., 3)`` of directions ``(..., 3)``: the shader's loop over wavelengths."""
        wi, wr = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wr, float))
        return method_xyz(self, wi, wr, illuminant, STEP_M, normalisation)


def method_xyz(
    method,
    wi: np.ndarray,
    wr: np.ndarray,
    illuminant: Illuminant = "D65",
    step_m: float = STEP_M,
    normalisation="absolute",
    stack: Stack | None = None,
) -> np.ndarray:
    """XYZ of any method by a loop over wavelengths, R = 1 or that of a stack.

    Parameters
    ----------
    method
        One of `precompute.evaluate.methods`.
    wi, wr
        ``(..., 3)``.
    illuminant, step_m
        Of the colour integral.
    normalisation
        ``absolute`` (1/sr) or ``relative``.
    stack
        What the surface is made of: its reflectance at the half angle counts.

    Returns
    -------
    ndarray
        ``(..., 3)``; 0 where a direction is not above the surface.
    """
    wi, wr = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wr, float))
    factor = geometry_factor(wi, wr)
    lit = factor > 0
    u, v, w = (a[lit] for a in uvw(wi, wr))
    total = np.zeros((u.size, 3))
    half = cos_half(wi, wr)[lit]
    for wavelength, weight in zip(*spectral_weights(illuminant=illuminant, step_m=step_m), strict=True):
        spectrum = method.transform(u, v, w, wavelength)
        if normalisation == "relative":
            spectrum = spectrum * relative_factor(wi[lit], wr[lit], wavelength, method.area_m2)
        if stack is not None:
            spectrum = spectrum * stack.reflectance(np.array([wavelength]), half)[0]
        total += spectrum[:, None] * weight
    result = np.zeros((*factor.shape, 3))
    result[lit] = factor[lit][:, None] * total
    return result
