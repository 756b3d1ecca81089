# SPDX-License-Identifier: GPL-3.0-or-later
"""Recipes whose grooves follow curves: rays, rings, spirals, guilloches.

The structure's grating vector lies along the tangent turned by Rotation, its grooves across it. Grooves that are the
level lines of a function F have their grating vector along grad F.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .recipe import Maps, Plane, Recipe, Setting


def _rays(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """Grooves along the rays from the middle: F = azimuth."""
    azimuth = np.arctan2(plane.y, plane.x)
    return {"rotation": values["turns"] * azimuth + 0.5 * np.pi}


def _rings(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """Concentric grooves: F = radius; with more than one band every other one is turned by a right angle."""
    radius = np.hypot(plane.x, plane.y)
    band = np.floor(radius * values["bands"]) if values["bands"] > 1 else np.zeros_like(radius)
    return {"rotation": np.arctan2(plane.y, plane.x) + 0.5 * np.pi * np.mod(band, 2.0)}


def _spiral(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """Logarithmic spirals, which meet every ray under one angle: F = azimuth cos(pitch) - log(r) sin(pitch)."""
    return {"rotation": np.arctan2(plane.y, plane.x) + 0.5 * np.pi + np.radians(values["pitch_deg"])}


def _guilloche(plane: Plane, values: Mapping[str, Any], pictures: tuple[np.ndarray, ...]) -> Maps:
    """Rosettes, the level lines of F = r (1 + a cos(n phi)), in lines of two families that mirror each other."""
    r, phi = np.hypot(plane.x, plane.y), np.arctan2(plane.y, plane.x)
    n, a = values["petals"], values["swing"]
    # Turning the second family by half a petal makes its lines cross those of the first.
    lines, rotation = [], []
    for turn in (0.0, np.pi / n):
        wave = n * (phi + turn)
        along_r, along_phi = 1.0 + a * np.cos(wave), -n * a * np.sin(wave)  # dF/dr and dF/dphi / r
        rotation.append(phi + np.arctan2(along_phi, along_r))
        lines.append(np.mod(r * along_r * values["lines"], 1.0))
    first = lines[0] < 0.5 * values["cover"]
    second = (lines[1] < 0.5 * values["cover"]) & ~first
    return {"rotation": np.where(second, rotation[1], rotation[0]), "mask": (first | second).astype(np.float32)}


RECIPES = (
    Recipe(
        "rays", "Rays", "Grooves along rays: a bow-tie of colour that turns with the light.", _rays,
        (Setting("turns", 1, 1, 64, "How often the direction turns round the middle"),),
    ),
    Recipe(
        "rings", "Rings", "Concentric grooves as on a disc: a line of colour from the middle to the light.", _rings,
        (Setting("bands", 1, 1, 200, "Rings of which every other one is turned by 90 degrees; 1 turns none"),),
    ),
    Recipe(
        "spiral", "Spiral", "Logarithmic spirals: the disc's line of colour, bent.", _spiral,
        (Setting("pitch_deg", 45.0, -90.0, 90.0, "Angle between groove and ray, degrees"),),
    ),
    Recipe(
        "guilloche", "Guilloche", "Two crossing families of rosette lines, as on banknotes.", _guilloche,
        (
            Setting("petals", 8, 1, 120, "Petals of the rosette"),
            Setting("swing", 0.25, 0.0, 0.95, "How far the lines swing, part of the radius"),
            Setting("lines", 24, 1, 400, "Lines from the middle to the rim"),
            Setting("cover", 0.5, 0.02, 1.0, "Part of the surface that one family covers"),
        ),
    ),
)  # fmt: skip
