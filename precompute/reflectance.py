# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflectance in the plane of incidence against the grating equation (thesis, chapter 4).

The response over (wavelength, view angle) has its peak where ``d (sin theta_i + sin theta_r) = m lambda``;
read backwards, the peak of each wavelength estimates the period d.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import ParameterError
from .methods import Method, relative_response


@dataclass(frozen=True)
class Reflectance:
    """Response of a surface in the plane of incidence.

    Parameters
    ----------
    wavelengths_m, views
        ``(L,)`` metres and ``(V,)`` radians, negative on the mirror direction's side of the normal.
    response
        ``(L, V)`` relative BRDF (1 for a flat patch at normal incidence) without Fresnel.
    peaks
        ``(L,)`` view angle of the largest response of each wavelength, a point of the grid.
    periods_m
        ``(L,)`` ``m lambda / (sin theta_i + sin theta_r)`` at the peaks.
    theta_i, order
        Radians; the order m.
    """

    wavelengths_m: np.ndarray
    views: np.ndarray
    response: np.ndarray
    peaks: np.ndarray
    periods_m: np.ndarray
    theta_i: float
    order: int

    @property
    def mean_nm(self) -> float:
        """Mean of the estimated period over the wavelengths."""
        return float(self.periods_m.mean() * 1e9)

    @property
    def variance_nm2(self) -> float:
        """Population variance of the estimated period over the wavelengths."""
        return float((self.periods_m * 1e9).var())

    def grating_angles(self, period_m: float) -> np.ndarray:
        """``(L,)`` view angles of the grating equation for a period; NaN where the order does not exist."""
        sine = self.order * self.wavelengths_m / period_m - np.sin(self.theta_i)
        return np.arcsin(np.where(np.abs(sine) <= 1.0, sine, np.nan))


def view_angles(start: float, stop: float, step: float) -> np.ndarray:
    """Angles from ``start`` to ``stop`` by ``step``, both ends included (any unit).

    Raises
    ------
    ParameterError
        If the step does not lead from start to stop, or there are fewer than 2 or more than 200,000 angles.
    """
    count = (stop - start) / step if step else np.inf
    if not (np.isfinite(count) and 1.0 <= count <= 200_000):
        raise ParameterError(
            f"From {start:g} to {stop:g} by {step:g} makes no series of angles; check the three numbers."
        )
    return start + step * np.arange(int(np.floor(count + 1e-9)) + 1)


def reflectance(
    method: Method,
    theta_i: float,
    views: np.ndarray,
    wavelengths_m: np.ndarray,
    azimuth: float = 0.0,
    order: int = 1,
) -> Reflectance:
    """Response and estimated period.

    Parameters
    ----------
    method
        From :func:`precompute.methods.make_method`.
    theta_i
        Light's polar angle, radians.
    views
        ``(V,)`` view angles in the plane of incidence, radians, positive on the light's side.
    wavelengths_m
        ``(L,)`` metres.
    azimuth
        Of the plane of incidence from the scan's x axis, radians.
    order
        Diffraction order m that the estimate takes.

    Raises
    ------
    ParameterError
        If an angle lies beyond the horizon, or the order is 0.
    """
    views, wavelengths_m = np.asarray(views, float), np.asarray(wavelengths_m, float)
    if not abs(theta_i) < 0.5 * np.pi or not (np.abs(views) < 0.5 * np.pi).all():
        raise ParameterError("Light and view angles must lie within 90 degrees of the normal.")
    if order == 0:
        raise ParameterError("Order 0 is the mirror direction for every period; choose another order.")
    along = np.array([np.cos(azimuth), np.sin(azimuth)])
    wi = np.array([*(np.sin(theta_i) * along), np.cos(theta_i)])
    wr = np.concatenate([np.sin(views)[:, None] * along, np.cos(views)[:, None]], -1)
    response = np.stack([relative_response(method, wi, wr, wavelength) for wavelength in wavelengths_m])
    peaks = views[response.argmax(1)]
    with np.errstate(divide="ignore"):
        periods = np.abs(order) * wavelengths_m / np.abs(np.sin(theta_i) + np.sin(peaks))
    return Reflectance(wavelengths_m, views, response, peaks, periods, float(theta_i), int(order))
