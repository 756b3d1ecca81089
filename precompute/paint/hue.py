# SPDX-License-Identifier: GPL-3.0-or-later
"""Hues as wavelengths: the dominant wavelength of a colour relative to white."""

from __future__ import annotations

import numpy as np

from ..light.colour import spectral_weights, white_xyz, xyz_to_rgb_matrix

#: Scales in a look-up of hues.
_STEPS = 1024

#: Beyond these the locus hardly moves: all longer wavelengths look alike.
SHORTEST_M, LONGEST_M = 400e-9, 680e-9


def _locus() -> tuple[np.ndarray, np.ndarray]:
    """Wavelengths and the angles of their chromaticities round D65, rising, radians."""
    wavelengths, weights = spectral_weights(illuminant="E")
    shown = (wavelengths >= SHORTEST_M) & (wavelengths <= LONGEST_M)
    angle = np.unwrap(_angle(weights[shown]))
    return (wavelengths[shown], angle) if angle[-1] > angle[0] else (wavelengths[shown][::-1], angle[::-1])


def _angle(xyz: np.ndarray) -> np.ndarray:
    """Direction from D65 in the CIE 1931 diagram, radians."""
    white = white_xyz("D65")
    total = np.maximum(xyz.sum(-1), 1e-300)
    return np.arctan2(xyz[..., 1] / total - white[1] / white.sum(), xyz[..., 0] / total - white[0] / white.sum())


def dominant_wavelength(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Dominant wavelengths of colours, and how saturated they are.

    Parameters
    ----------
    rgb
        ``(..., 3)`` linear Rec.709, none negative.

    Returns
    -------
    tuple of ndarray
        ``(...)`` metres, NaN for purples, which no wavelength has; and the saturation, 0 for greys to 1 where one of
        the primaries is absent.
    """
    rgb = np.asarray(rgb, float)
    wavelengths, angles = _locus()
    xyz = rgb @ np.linalg.inv(xyz_to_rgb_matrix("Linear Rec.709")).T
    angle = angles[0] + np.mod(_angle(xyz) - angles[0], 2.0 * np.pi)
    found = np.interp(angle, angles, wavelengths)
    largest = rgb.max(-1)
    saturation = np.where(largest > 0, 1.0 - rgb.min(-1) / np.maximum(largest, 1e-300), 0.0)
    return np.where(angle <= angles[-1], found, np.nan), saturation


def order_hues(sines: float, period_m: float, sigma_s_m: float, most: float) -> tuple[np.ndarray, np.ndarray]:
    """What hue order 1 shows in daylight at each scale of a grating.

    The order's lobe at one wavelength is ``exp(-(k sigma s)^2 (u - lambda / (s d))^2) / lambda^2`` (the Gaussian window
    of width ``s sigma``), so that towards one direction a band of wavelengths arrives.

    Parameters
    ----------
    sines
        |u| = sine of the lamp plus sine of the viewer.
    period_m, sigma_s_m
        Of the table, metres.
    most
        Largest scale.

    Returns
    -------
    tuple of ndarray
        Scales and the dominant wavelengths seen, metres; both rise.
    """
    scales = np.linspace(0.9 * SHORTEST_M, 1.15 * LONGEST_M, _STEPS) / (sines * period_m)
    scales = scales[scales <= most]
    if scales.size < 2:
        return np.array([most, most]), np.array([0.0, 0.0])
    wavelengths, weights = spectral_weights()
    off = sines / wavelengths - 1.0 / (scales[:, None] * period_m)
    band = np.exp(-((2.0 * np.pi * sigma_s_m * scales[:, None] * off) ** 2)) / wavelengths**2
    xyz = band @ weights
    hue, _ = dominant_wavelength(np.maximum(xyz, 0.0) @ xyz_to_rgb_matrix("Linear Rec.709").T)
    fine = np.isfinite(hue)
    scales, hue = scales[fine], hue[fine]
    if scales.size < 2:
        return np.array([most, most]), np.array([0.0, 0.0])
    rising = np.concatenate([[True], hue[1:] > np.maximum.accumulate(hue)[:-1]])
    return scales[rising], hue[rising]
