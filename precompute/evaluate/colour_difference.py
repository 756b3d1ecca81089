# SPDX-License-Identifier: GPL-3.0-or-later
"""How different two pictures of a BRDF look: CIE Delta E 2000 as displayed."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..light.colour import white_xyz
from ..light.colour_library import load_colour
from .disc_map import exposure_of


def delta_e_2000(
    result: np.ndarray, reference: np.ndarray, exposure: float | None = None, illuminant: str = "D65"
) -> np.ndarray:
    """Colour difference of values of a BRDF, shown side by side at the same exposure.

    What is brighter than the display's white is shown as bright as white and keeps its chromaticity, as
    `precompute.evaluate.disc_map.map_to_srgb` shows it.

    Parameters
    ----------
    result, reference
        ``(..., 3)`` XYZ in 1/sr.
    exposure
        Factor on both; None takes `precompute.evaluate.disc_map.exposure_of` the reference.
    illuminant
        Whose white is the white of the comparison.

    Returns
    -------
    ndarray
        ``(...)`` Delta E 2000 (CIE 142-2001, ISO/CIE 11664-6); about 1 is just noticeable.

    Raises
    ------
    ParameterError
        If the shapes differ.
    """
    colour = load_colour()

    result, reference = np.asarray(result, float), np.asarray(reference, float)
    if result.shape != reference.shape or result.shape[-1:] != (3,):
        raise ParameterError(f"Colours of the shapes {result.shape} and {reference.shape} cannot be compared.")
    factor = exposure_of(reference, illuminant) if exposure is None else exposure
    white = white_xyz(illuminant)
    xy = white[:2] / white.sum()

    def lab(xyz: np.ndarray) -> np.ndarray:
        shown = factor * np.maximum(xyz, 0.0)
        return colour.XYZ_to_Lab(shown / np.maximum(1.0, shown[..., 1:2]), xy)

    return np.asarray(colour.delta_E(lab(result), lab(reference), method="CIE 2000"))
