# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflectance against the grating equation: response over (wavelength, view angle) in a plane of incidence.

The light stands at theta_i in the plane of azimuth phi, the viewer in the same plane at theta_r (negative: on the
other side of the normal). Order m of a grating of period d along that azimuth leaves where
``sin(theta_i) + sin(theta_r) = m lambda / d``; read backwards, the peak of each wavelength estimates d.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import ParameterError
from ..scan.heightfield import HeightField
from ..stack import Stack
from .directions import from_angles, uvw
from .methods import make_method
from .methods.bins import Band
from .surface import cos_half, geometry_factor, relative_factor


@dataclass(frozen=True, eq=False)
class Plane:
    """What is measured.

    Parameters
    ----------
    theta_i, phi
        Light's polar angle and the azimuth of the plane of incidence, radians.
    theta_r
        ``(V,)`` view angles in radians.
    wavelengths_m
        ``(L,)``.
    order
        The order whose peak the views hold.

    Raises
    ------
    ParameterError
        If light or viewer are not above the surface, or the order cannot leave towards the views.
    """

    theta_i: float
    theta_r: np.ndarray
    wavelengths_m: np.ndarray
    phi: float = 0.0
    order: int = 1

    def __post_init__(self) -> None:
        if not abs(self.theta_i) < np.pi / 2 or not (np.abs(self.theta_r) < np.pi / 2).all():
            raise ParameterError("Light and viewer must stand above the surface; give angles between -90 and 90 deg.")
        if len(self.theta_r) < 2 or len(self.wavelengths_m) < 2:
            raise ParameterError("A reflectance plot needs at least two view angles and two wavelengths.")
        if self.order == 0 or not isinstance(self.order, int):
            raise ParameterError("The order must be a whole number other than 0; the mirror says nothing of a period.")
        # sin(theta_i) + sin(theta_r) has the order's sign wherever that order leaves.
        if (self.sines * np.sign(self.order) <= 0).any():
            raise ParameterError(
                "The views include the mirror direction or lie on its other side, where this order cannot leave;"
                " change --from and --to, or the sign of --order."
            )

    @property
    def sines(self) -> np.ndarray:
        """``(V,)`` sin(theta_i) + sin(theta_r) = -u along the azimuth."""
        return np.sin(self.theta_i) + np.sin(self.theta_r)

    def directions(self) -> tuple[np.ndarray, np.ndarray]:
        """``(3,)`` towards the light and ``(V, 3)`` towards the viewers."""
        return from_angles(self.theta_i, self.phi), from_angles(self.theta_r, self.phi)

    def band(self) -> Band:
        """The part of the frequency plane that the plane of incidence asks for."""
        ends = np.array([self.sines.min(), self.sines.max()])
        inverse = 1.0 / np.array([self.wavelengths_m.min(), self.wavelengths_m.max()])
        f = -np.outer(ends, inverse).ravel()
        axes = (f * np.cos(self.phi), f * np.sin(self.phi))
        return Band(*((float(a.min()), float(a.max())) for a in axes))


def steps(first: float, last: float, step: float) -> np.ndarray:
    """first, first + step ... up to and including last (as nearly as rounding allows)."""
    if not step > 0 or not last > first or (last - first) / step > 1e6:
        raise ParameterError(f"From {first:g} to {last:g} by {step:g} gives no usable grid; use a rising range.")
    return first + step * np.arange(int(np.floor((last - first) / step + 1e-6)) + 1)


def response(
    field: HeightField,
    plane: Plane,
    method: str = "windowed",
    normalisation: str = "relative",
    progress: Callable[[str, float], None] | None = None,
    stack: Stack | None = None,
    **options: Any,
) -> tuple[np.ndarray, dict[str, Any]]:
    """BRDF over wavelengths and views, R = 1 or that of a stack.

    Parameters
    ----------
    field
        A prepared heightfield.
    plane
        Light, views, wavelengths.
    method, options
        See `precompute.evaluate.methods.make_method`.
    normalisation
        ``relative`` (factor C of the thesis) or ``absolute`` (1/sr).
    progress
        Called with a text and the fraction that is done; an exception it raises ends the computation.
    stack
        What the surface is made of: its reflectance at the half angle is multiplied in.

    Returns
    -------
    values : ndarray
        ``(L, V)``.
    facts : dict
        What the method cost.
    """
    made = make_method(method, field, band=plane.band(), **options)
    wi, wr = plane.directions()
    factor = geometry_factor(wi, wr)
    u, v, w = uvw(wi, wr)
    if abs(np.sin(plane.phi)) < 1e-12:
        # Exactly one line of frequencies, which the methods sum faster.
        v = np.zeros_like(v)
    rows = []
    for index, wavelength in enumerate(plane.wavelengths_m):
        if progress is not None:
            progress("reflectance", index / len(plane.wavelengths_m))
        row = factor * made.transform(u, v, w, wavelength)
        if normalisation == "relative":
            row = row * relative_factor(wi, wr, wavelength, made.area_m2)
        if stack is not None:
            row = row * stack.reflectance(np.array([wavelength]), cos_half(wi, wr))[0]
        rows.append(row)
    return np.array(rows), made.facts


def estimated_periods(plane: Plane, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """View of the largest response of each wavelength, and the period it stands for.

    Parameters
    ----------
    values
        ``(L, V)`` response.

    Returns
    -------
    theta_r : ndarray
        ``(L,)`` radians, on the grid of views: no interpolation.
    periods_m : ndarray
        ``(L,)`` d = m lambda / (sin(theta_i) + sin(theta_r)).
    """
    peak = values.argmax(axis=1)
    return plane.theta_r[peak], plane.order * plane.wavelengths_m / plane.sines[peak]


def grating_curve(plane: Plane, period_m: float) -> np.ndarray:
    """``(L,)`` views (radians) where the grating equation puts the order; NaN where it does not leave."""
    sine = plane.order * plane.wavelengths_m / period_m - np.sin(plane.theta_i)
    return np.where(np.abs(sine) <= 1, np.arcsin(np.clip(sine, -1, 1)), np.nan)
