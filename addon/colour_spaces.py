# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour spaces of whatever OpenColorIO configuration Blender runs with, found by what they mean.

Blender's own configuration says "Non-Color", "sRGB" and "Linear Rec.709"; those of ACES say "Raw", "sRGB - Texture" and
"Linear Rec.709 (sRGB)", and a studio's say what it likes. So a space is looked up by its role first, then by its alias
or its definition where OpenColorIO's own module is there (Blender brings it), then by the names in use, and where all
that fails one sentence says what the configuration lacks.
"""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np

from ..precompute.errors import ParameterError

#: Scene-linear space of the colour configuration of Blender 4.5, which has no setting for it.
FIXED_WORKING_SPACE = "Linear Rec.709"

#: Names and aliases in use, the interchange identifiers of the Color Interop Forum first.
SRGB = (
    "srgb_rec709_scene", "srgb_texture", "sRGB", "sRGB - Texture", "sRGB Encoded Rec.709 (sRGB)",
    "Utility - sRGB - Texture",
)  # fmt: skip
LINEAR_REC709 = (
    "lin_rec709_scene", "lin_rec709", "Linear Rec.709", "Linear Rec.709 (sRGB)", "Utility - Linear - sRGB", "Linear",
)  # fmt: skip

#: Working spaces by their interchange identifiers, as `precompute.light.colour.SPACES` names them.
INTEROP = {"lin_rec709_scene": "Linear Rec.709", "lin_rec2020_scene": "Linear Rec.2020", "lin_ap1_scene": "ACEScg"}

#: The same by their names in the configurations in use.
NAMES = {
    "Linear Rec.709": "Linear Rec.709",
    "Linear Rec.709 (sRGB)": "Linear Rec.709",
    "Utility - Linear - sRGB": "Linear Rec.709",
    "Linear": "Linear Rec.709",
    "Linear Rec.2020": "Linear Rec.2020",
    "Utility - Linear - Rec.2020": "Linear Rec.2020",
    "ACEScg": "ACEScg",
    "ACES - ACEScg": "ACEScg",
}

#: The same by their definition: matrices to ACES2065-1 (Academy S-2014-004 and TB-2014-012; Bradford's adaptation).
TO_ACES = {
    "Linear Rec.709": ((0.4396, 0.3830, 0.1774), (0.0898, 0.8134, 0.0968), (0.0175, 0.1115, 0.8709)),
    "Linear Rec.2020": ((0.6791, 0.1577, 0.1632), (0.0461, 0.8596, 0.0944), (-0.0006, 0.0285, 0.9721)),
    "ACEScg": ((0.6955, 0.1407, 0.1639), (0.0448, 0.8597, 0.0955), (-0.0055, 0.0040, 1.0015)),
}


def set_data(image: bpy.types.Image) -> None:
    """Let an image hold numbers, not colours: no transform touches them.

    Raises
    ------
    ParameterError
        If the colour configuration has no space for that.
    """
    settings = image.colorspace_settings
    if settings.is_data:
        return
    settings.is_data = True  # by the role `data`
    if not settings.is_data:
        _choose(settings, ("Non-Color", "Raw", "raw", "data", "Utility - Raw"), "numbers (Non-Color, Raw)")
    if not settings.is_data:
        raise ParameterError(_lacks("numbers (Non-Color, Raw)"))


def set_picture(image: bpy.types.Image, linear: bool = False) -> None:
    """Let an image hold display values (sRGB), or linear ones with the primaries of Rec.709.

    Raises
    ------
    ParameterError
        If the colour configuration has no such space.
    """
    if linear:
        _choose(image.colorspace_settings, LINEAR_REC709, "linear Rec.709")
    else:
        _choose(image.colorspace_settings, SRGB, "sRGB")


def set_scene_linear(image: bpy.types.Image) -> None:
    """Let an image hold values of the scene's working space.

    Raises
    ------
    ParameterError
        If the colour configuration does not tell which that is.
    """
    _choose(image.colorspace_settings, (file_space(), "scene_linear"), "the working space")


def working_space() -> str:
    """The file's working space under the name of `precompute.light.colour.SPACES`, by its definition.

    Raises
    ------
    ParameterError
        If it is none of them.
    """
    colorspace = getattr(bpy.data, "colorspace", None)
    if colorspace is None:
        return FIXED_WORKING_SPACE
    found = INTEROP.get(getattr(colorspace, "working_space_interop_id", "")) or _by_definition()
    found = found or NAMES.get(colorspace.working_space)
    if found is None:
        raise ParameterError(
            f"The working space '{colorspace.working_space}' is not known here; choose Linear Rec.709, Linear Rec.2020 "
            "or ACEScg in the colour configuration or in Render > Color Management."
        )
    return found


def file_space() -> str:
    """What the file calls its working space: enough to see that it changed."""
    colorspace = getattr(bpy.data, "colorspace", None)
    return FIXED_WORKING_SPACE if colorspace is None else colorspace.working_space


def _configuration() -> Any:
    """OpenColorIO's current configuration; None where Blender does not hand out its module."""
    try:
        import PyOpenColorIO
    except ImportError:
        return None
    return PyOpenColorIO.GetCurrentConfig()


def _by_definition() -> str | None:
    """The working space by its matrix to ACES2065-1."""
    configuration = _configuration()
    if configuration is None or not (
        configuration.hasRole("scene_linear") and configuration.hasRole("aces_interchange")
    ):
        return None
    processor = configuration.getProcessor("scene_linear", "aces_interchange").getDefaultCPUProcessor()
    matrix = np.stack([processor.applyRGB(list(axis)) for axis in np.eye(3)], axis=-1)
    for name, known in TO_ACES.items():
        if np.allclose(matrix, known, atol=2e-3):
            return name
    return None


def _choose(settings: bpy.types.ColorManagedInputColorspaceSettings, names: tuple[str, ...], wanted: str) -> None:
    """Take the first of some names that the configuration knows, as alias or as name.

    Raises
    ------
    ParameterError
        If it knows none.
    """
    configuration = _configuration()
    for name in names:
        space = configuration.getColorSpace(name) if configuration is not None else None
        for candidate in (space.getName() if space is not None else name, name):
            try:
                settings.name = candidate
            except TypeError:  # not in this configuration
                continue
            return
    raise ParameterError(_lacks(wanted))


def _lacks(wanted: str) -> str:
    return f"The colour configuration (OCIO) has no space for {wanted}; start Blender with another or add one."
