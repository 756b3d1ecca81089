# SPDX-License-Identifier: GPL-3.0-or-later
"""The light and its colours: spectra of illuminants, the observer, XYZ and the working spaces.

`illuminant_of` names the light, `spectral_weights` turns it into weights of the wavelengths, `xyz_to_rgb_matrix` and
`into_gamut` bring XYZ into a scene's working space. Data and matrices come from colour-science.
"""

from .colour import (
    adaptation,
    can_be_white,
    encode_srgb,
    into_gamut,
    luminance_row,
    spectral_weights,
    table_light,
    white_xyz,
    xyz_to_rgb,
    xyz_to_rgb_matrix,
)
from .illuminant import ILLUMINANTS, Spectrum, illuminant_of, read_spectrum

__all__ = [
    "ILLUMINANTS",
    "Spectrum",
    "adaptation",
    "can_be_white",
    "encode_srgb",
    "illuminant_of",
    "into_gamut",
    "luminance_row",
    "read_spectrum",
    "spectral_weights",
    "table_light",
    "white_xyz",
    "xyz_to_rgb",
    "xyz_to_rgb_matrix",
]
