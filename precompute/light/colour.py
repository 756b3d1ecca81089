# SPDX-License-Identifier: GPL-3.0-or-later
"""From spectra to XYZ to the RGB of a scene: quadrature weights, matrices and the gamut step.

Colour matching functions (CIE 1931, 2 degrees), illuminants, Bradford's matrix and RGB primaries are those of
colour-science, from the file of `precompute.light.colour_data`; the library itself is not imported.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from ..constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M
from ..errors import ParameterError
from . import colour_data
from .illuminant import Illuminant, illuminant_of

#: Working spaces by the names that ``bpy.data.colorspace.working_space`` gives, and their names in colour-science.
SPACES = {"Linear Rec.709": "ITU-R BT.709", "Linear Rec.2020": "ITU-R BT.2020", "ACEScg": "ACEScg"}

OBSERVER = "CIE 1931 2 Degree Standard Observer"

#: Default step of the wavelength quadrature, the step at which the CIE tabulates the observer.
STEP_M = 1e-9

#: Smallest response of a cone to a light with Y = 1 to which colours are adapted; illuminant A has 0.34.
LEAST_CONE = 0.02

#: What the colours of a table are adapted to.
ADAPTED = "D65"


def wavelength_grid(step_m: float = STEP_M) -> np.ndarray:
    """Equidistant wavelengths from 380 to 780 nm, both ends included, at most ``step_m`` apart, in metres."""
    span = WAVELENGTH_MAX_M - WAVELENGTH_MIN_M
    if not (np.isfinite(step_m) and 0 < step_m <= span):
        raise ParameterError(f"A wavelength step of {step_m * 1e9:g} nm makes no sense; use 0.1 to 20 nm.")
    # The small slack keeps 400 / 2.5 from becoming 161 intervals by rounding.
    return np.linspace(WAVELENGTH_MIN_M, WAVELENGTH_MAX_M, int(np.ceil(span / step_m - 1e-6)) + 1)


def spectral_weights(
    wavelengths_m: np.ndarray | None = None, illuminant: Illuminant = "D65", step_m: float = STEP_M
) -> tuple[np.ndarray, np.ndarray]:
    """Weights that turn a spectrum f(lambda) into XYZ under an illuminant.

    ``XYZ = sum_l weights[l] f[l]`` is the trapezoid rule for
    ``integral f S (xbar, ybar, zbar) dlambda / integral S ybar dlambda``, normalised by the same
    quadrature, so that ``f = 1`` gives Y = 1 to rounding.

    Parameters
    ----------
    wavelengths_m
        ``(L,)`` rising wavelengths in metres; a grid of ``step_m`` over 380-780 nm when None.
    illuminant
        One of `ILLUMINANTS`, a `precompute.light.illuminant.Spectrum`, or what a table's sidecar says of either.
    step_m
        Step of the default grid in metres.

    Returns
    -------
    wavelengths_m : ndarray
        ``(L,)`` metres. Read-only.
    weights : ndarray
        ``(L, 3)`` without unit. Read-only.

    Raises
    ------
    ParameterError
        For an unknown illuminant, or wavelengths that do not rise or leave 380-780 nm.
    """
    grid = wavelength_grid(step_m) if wavelengths_m is None else np.asarray(wavelengths_m, float)
    return _weights(tuple(grid.tolist()), illuminant_of(illuminant))


@lru_cache(maxsize=64)
def _weights(wavelengths: tuple[float, ...], illuminant: Illuminant) -> tuple[np.ndarray, np.ndarray]:
    lam = np.array(wavelengths)
    slack = 1e-12
    if lam.size < 2 or (np.diff(lam) <= 0).any():
        raise ParameterError("The wavelengths of a colour integral must be at least two, in rising order.")
    if lam[0] < WAVELENGTH_MIN_M - slack or lam[-1] > WAVELENGTH_MAX_M + slack:
        raise ParameterError("The wavelengths of a colour integral must lie within 380-780 nm.")
    nm, cmfs = colour_data.observer()
    x = lam * 1e9
    xyz = np.stack([np.interp(x, nm, cmfs[:, c]) for c in range(3)], axis=-1)
    step = np.diff(lam)
    quadrature = np.zeros_like(lam)
    quadrature[:-1] += step / 2
    quadrature[1:] += step / 2
    light = _named(illuminant, x) if isinstance(illuminant, str) else illuminant.on(lam)
    weights = (quadrature * light)[:, None] * xyz
    luminance = weights[:, 1].sum()
    if not luminance > 0.0:
        raise ParameterError(f"The light '{illuminant}' has no luminance; choose one that can be seen.")
    weights /= luminance
    lam.flags.writeable = weights.flags.writeable = False
    return lam, weights


def _named(name: str, wavelengths_nm: np.ndarray) -> np.ndarray:
    """The CIE defines its illuminants between their 5 nm samples by linear interpolation (CIE 15:2018, 4.2)."""
    return np.interp(wavelengths_nm, *colour_data.illuminant(name))


def white_xyz(illuminant: Illuminant = "D65") -> np.ndarray:
    """``(3,)`` XYZ of a spectrally flat f = 1 under ``illuminant``, with Y = 1, on the default wavelength grid."""
    return spectral_weights(illuminant=illuminant)[1].sum(axis=0)


@lru_cache(maxsize=32)
def _xyz_to_rgb(space: str, illuminant: Illuminant) -> np.ndarray:
    if space not in SPACES:
        raise ParameterError(f"Unknown working space '{space}'; choose one of {', '.join(SPACES)}.")
    primaries_xy, white_xy = colour_data.space(SPACES[space])

    def xyz_of(xy: np.ndarray) -> np.ndarray:
        x, y = xy
        return np.array([x / y, 1.0, (1.0 - x - y) / y])

    # Built from the primaries: the published matrices are rounded and miss (1, 1, 1) by up to 1e-4.
    white = xyz_of(white_xy)
    primaries = np.stack([xyz_of(xy) for xy in primaries_xy], axis=-1)
    rgb_to_xyz = primaries * np.linalg.solve(primaries, white)
    bradford = colour_data.bradford()
    seen = bradford @ white_xyz(illuminant)
    adapt = np.eye(3)
    if can_be_white(illuminant):
        adapt = np.linalg.solve(bradford, (bradford @ white / seen)[:, None] * bradford)
    matrix = np.linalg.solve(rgb_to_xyz, adapt)
    matrix.flags.writeable = False
    return matrix


def can_be_white(illuminant: Illuminant) -> bool:
    """Whether eyes adapt to a light: lasers and sodium lamps leave a kind of cone (after Bradford) in the dark."""
    return bool((colour_data.bradford() @ white_xyz(illuminant)).min() > LEAST_CONE)


def adaptation(illuminant: Illuminant) -> np.ndarray | None:
    """``(3, 3)`` Bradford matrix from XYZ under a light to XYZ under D65; None for a light that cannot be white.

    Both whites are those of `white_xyz`. The identity, exactly, for D65.
    """
    light = illuminant_of(illuminant)
    if light == ADAPTED:
        return np.eye(3)
    if not can_be_white(light):
        return None
    cones = colour_data.bradford()
    gains = (cones @ white_xyz(ADAPTED)) / (cones @ white_xyz(light))
    return np.linalg.solve(cones, gains[:, None] * cones)


def table_light(colour: Mapping[str, Any]) -> Illuminant:
    """The light whose white a table's XYZ is relative to, by the entry ``colour`` of its sidecar.

    D65 where the note ``adapted`` says so (format 2), so that the matrix to a working space depends on that space
    alone; else the light of the bake (format 1, and lights that cannot be white).
    """
    return illuminant_of(colour.get("adapted") or colour["illuminant"])


def xyz_to_rgb_matrix(space: str = "Linear Rec.709", illuminant: Illuminant = "D65") -> np.ndarray:
    """Matrix from XYZ under ``illuminant`` to linear RGB in which the illuminant's white is (1, 1, 1).

    A light that cannot be adapted to (`can_be_white`) keeps its own colour: relative to the white of the space.

    Parameters
    ----------
    space
        One of `SPACES`, the names of ``bpy.data.colorspace.working_space``.
    illuminant
        As for `spectral_weights`; adapted to the white of the space after Bradford.

    Returns
    -------
    ndarray
        ``(3, 3)``, ``rgb = matrix @ xyz``. Read-only.
    """
    return _xyz_to_rgb(space, illuminant_of(illuminant))


def luminance_row(space: str = "Linear Rec.709", illuminant: Illuminant = "D65") -> np.ndarray:
    """``(3,)`` row that gives back Y: ``Y = row . rgb`` for ``rgb = xyz_to_rgb_matrix(...) @ xyz``. It sums to 1."""
    return np.linalg.inv(xyz_to_rgb_matrix(space, illuminant))[1]


def xyz_to_rgb(xyz: np.ndarray, space: str = "Linear Rec.709", illuminant: Illuminant = "D65") -> np.ndarray:
    """Linear RGB ``(..., 3)`` of XYZ ``(..., 3)``; components may be negative, see `into_gamut`."""
    return np.asarray(xyz) @ xyz_to_rgb_matrix(space, illuminant).T


def into_gamut(rgb: np.ndarray, row: np.ndarray) -> np.ndarray:
    """Move colours with a negative component towards the grey of the same luminance until that component is zero.

    Luminance and dominant wavelength stay; hues do not flip as they do when components are clipped.

    Parameters
    ----------
    rgb
        ``(..., 3)`` linear RGB, any scale.
    row
        ``(3,)`` `luminance_row` of the space.

    Returns
    -------
    ndarray
        ``(..., 3)``, no component below zero. A colour without luminance becomes black.
    """
    rgb = np.asarray(rgb, float)
    grey = (rgb @ np.asarray(row, float))[..., None]
    lowest = rgb.min(axis=-1, keepdims=True)
    outside = lowest < 0
    factor = grey / np.where(outside, grey - lowest, 1.0)
    moved = np.where(grey > 0, np.maximum(grey + (rgb - grey) * factor, 0.0), 0.0)
    return np.where(outside, moved, rgb)


def encode_srgb(linear: np.ndarray) -> np.ndarray:
    """The sRGB transfer curve (IEC 61966-2-1) of linear Rec.709 values, clipped to 0..1."""
    linear = np.clip(linear, 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * np.power(linear, 1 / 2.4) - 0.055)
