# SPDX-License-Identifier: GPL-3.0-or-later
"""The colour of a flat mirror of some stuff: by the formulas, and as a table of a flat plate shows it."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..light.colour import adaptation, spectral_weights
from ..light.illuminant import Illuminant
from ..parameters import BakeParameters
from ..stack import Material, Stack, fresnel_exact
from ..table.table import SpectralTable
from .directions import from_angles
from .surface import brdf

#: A flat plate's side and coherence window in metres, and how far round the mirror direction its lobe is summed.
_SIDE_M, _SIGMA_M, _LOBE = 24e-6, 5e-6, 0.12


def mirror_xyz(
    stack: Stack | None, theta: np.ndarray, illuminant: Illuminant = "D65", lacquer: Material | None = None
) -> np.ndarray:
    """XYZ of what a flat mirror reflects, ``integral R S xyz dlambda / integral S ybar dlambda``.

    Parameters
    ----------
    stack
        Films and substrate; None for R = 1.
    theta
        Angles in air, radians, any shape.
    illuminant
        The light; where it can be white the colours are adapted to D65, as tables are.
    lacquer
        A clear layer over it: then ``t^2 R(theta')``, t the transmittance of its face and theta' the angle inside; what
        its own face reflects is left out.

    Returns
    -------
    ndarray
        ``(..., 3)``, 1 as white.
    """
    wavelengths, weights = spectral_weights(illuminant=illuminant)
    cosine, index = np.cos(np.asarray(theta, float)), BakeParameters(lacquer=lacquer).index
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    through = 1.0 - fresnel_exact(index, cosine) if index > 1.0 else np.ones_like(cosine)
    r = np.ones((len(wavelengths), *cosine.shape)) if stack is None else stack.reflectance(wavelengths, inside, lacquer)
    xyz = np.moveaxis(r, 0, -1) @ weights
    to_adapted = adaptation(illuminant)
    return through[..., None] ** 2 * (xyz if to_adapted is None else xyz @ to_adapted.T)


def plate_table(stack: Stack | None, illuminant: Illuminant = "D65", lacquer: Material | None = None) -> SpectralTable:
    """Bake a flat plate of some stuff, None for R = 1."""
    from ..bake import bake
    from ..presets import make_preset

    parameters = BakeParameters(sigma_s_m=_SIGMA_M, level="none", stack=stack, illuminant=illuminant, lacquer=lacquer)
    return bake(make_preset("flat", _SIDE_M, 256), parameters)


def seen_mirror_xyz(
    table: SpectralTable,
    bare: SpectralTable,
    theta: float,
    illuminant: Illuminant = "D65",
    lacquer: Material | None = None,
) -> np.ndarray:
    """XYZ that a flat plate's table sends towards the mirror direction: ``integral f du dv`` over its lobe.

    About 1 % of the light lies further out, where a patch's rim sends it; the same plate with R = 1 tells how much.

    Parameters
    ----------
    table, bare
        Of `plate_table`, with a stack and without.
    illuminant, lacquer
        With which both were baked.
    theta
        Angle in air, radians, at most 75 degrees: nearer the horizon the lobe is cut off.

    Returns
    -------
    ndarray
        ``(3,)``, 1 as white.
    """
    if not 0.0 <= theta <= np.radians(75.0):
        raise ParameterError(f"A plate's lobe is whole up to 75 degrees, not at {np.degrees(theta):g}; give less.")
    wi, centre = from_angles(theta, np.pi), np.sin(theta)
    reach = min(_LOBE, 0.95 * (1.0 - centre))
    # Rings of equal steps in the root of the radius, which crowd where the lobe is.
    edge = np.linspace(0.0, 1.0, 241) ** 2 * reach
    radius, turn = 0.5 * (edge[1:] + edge[:-1]), 2.0 * np.pi * (np.arange(96) + 0.5) / 96
    x, y = centre + np.outer(radius, np.cos(turn)), np.outer(radius, np.sin(turn))
    wr = np.stack([x, y, np.sqrt(1.0 - x**2 - y**2)], -1)
    area = (radius * np.diff(edge))[:, None] * (2.0 * np.pi / 96)
    seen, whole = ((brdf(each, wi, wr) * area[..., None]).sum((0, 1)) for each in (table, bare))
    return seen / whole * mirror_xyz(None, np.asarray(theta), illuminant, lacquer)
