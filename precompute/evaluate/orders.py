# SPDX-License-Identifier: GPL-3.0-or-later
"""Order efficiencies of a periodic profile in the scalar model: what a grating's makers and handbooks state.

A directional light of irradiance E leaves ``L = f E cos_i``; the part of its power that goes into a solid angle is
``integral f cos_r dw = integral f du dv`` since ``du dv = cos_r dw``. On a surface of period d all of T stands in
orders at ``u = -m lambda / d``, so order m takes

    e_m = R (1 + wi.wr)^2 / (cos_i cos_r w^2) |P_m|^2,     P_m = (1 / d) integral exp(i k w_m h - 2 pi i m x / d) dx

over one period, with ``w_m`` and R those of its own direction.
"""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from ..stack import Stack
from .directions import from_angles, uvw
from .surface import cos_half, geometry_factor, schlick


def order_directions(period_m: float, wavelength_m: float, theta_i: float) -> tuple[np.ndarray, np.ndarray]:
    """Orders that leave the surface, and where to.

    Light comes from the side of negative x, so the mirror direction lies at positive x.

    Parameters
    ----------
    period_m, wavelength_m
        Metres.
    theta_i
        Angle of incidence in radians.

    Returns
    -------
    m : ndarray
        ``(n,)`` ascending; ``sin theta_m = sin theta_i + m lambda / d`` (the grating equation).
    wr : ndarray
        ``(n, 3)`` unit vectors.
    """
    for name, value in (("period", period_m), ("wavelength", wavelength_m)):
        if not (np.isfinite(value) and value > 0):
            raise ParameterError(f"A {name} of {1e9 * value:.6g} nm makes no sense; give a positive length.")
    if not 0.0 <= theta_i < 0.5 * np.pi:
        raise ParameterError(f"The angle of incidence is {np.degrees(theta_i):g} degrees; give 0 to below 90.")
    furthest = int(2.0 * period_m / wavelength_m) + 1
    m = np.arange(-furthest, furthest + 1)
    sine = np.sin(theta_i) + m * wavelength_m / period_m
    m, sine = m[np.abs(sine) < 1.0], sine[np.abs(sine) < 1.0]
    return m, np.stack([sine, np.zeros_like(sine), np.sqrt(1.0 - sine**2)], axis=-1)


def order_efficiencies(
    profile: np.ndarray,
    period_m: float,
    wavelength_m: float,
    theta_i: float,
    r0: float | None = None,
    stack: Stack | None = None,
    conserving: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Parts of the incident power that the orders of a grating carry.

    Parameters
    ----------
    profile
        ``(n,)`` heights at equal steps over one period, metres.
    period_m, wavelength_m
        Metres.
    theta_i
        Angle of incidence in radians, in the plane across the grooves.
    r0
        Reflectance at normal incidence of Schlick's R; None leaves Fresnel away (R = 1).
    stack
        What the grating is made of; its reflectance at each order's half angle takes the place of Schlick's.
    conserving
        Whether each order is divided by max(1, a(theta_i), a(theta_m)), a the sum of all orders with R = 1 of light
        from there: then no direction sends out more than came in. The table's renderers do the same.

    Raises
    ------
    ParameterError
        For lengths, angles and profiles that make no sense, or both ``r0`` and ``stack``.

    Returns
    -------
    m : ndarray
        ``(orders,)``, see `order_directions`.
    efficiency : ndarray
        ``(orders,)`` without unit.
    """
    profile = np.asarray(profile, float)
    if profile.ndim != 1 or profile.size < 2 or not np.isfinite(profile).all():
        raise ParameterError("A profile is a row of at least two finite heights over one period.")
    m, wr = order_directions(period_m, wavelength_m, theta_i)
    wi = from_angles(theta_i, np.pi)
    plain = _plain(profile, wavelength_m, m, wi, wr)
    if stack is not None:
        if r0 is not None:
            raise ParameterError("Give either r0 or a stack: both are the reflectance.")
        plain_r = stack.reflectance(np.array([wavelength_m]), cos_half(wi, wr))[0]
    else:
        plain_r = np.ones(len(m)) if r0 is None else schlick(cos_half(wi, wr), r0)
    if conserving:
        excess = np.array([_albedo(profile, period_m, wavelength_m, each) for each in wr])
        plain = plain / np.maximum(1.0, np.maximum(plain.sum(), excess))
    return m, plain_r * plain


def _plain(profile: np.ndarray, wavelength_m: float, m: np.ndarray, wi: np.ndarray, wr: np.ndarray) -> np.ndarray:
    """Parts of the light in the orders, R = 1."""
    w = uvw(wi, wr)[2]
    x = np.arange(profile.size) / profile.size
    phase = 2.0 * np.pi * (w[:, None] / wavelength_m * profile - m[:, None] * x)
    return geometry_factor(wi, wr) * np.abs(np.exp(1j * phase).mean(axis=1)) ** 2


def _albedo(profile: np.ndarray, period_m: float, wavelength_m: float, place: np.ndarray) -> float:
    """All that light from the place of an order sends out, R = 1.

    Light from the side of positive x is light from that of negative x on the profile read backwards.
    """
    sine = float(place[0])
    seen = profile if sine <= 0.0 else profile[::-1]
    theta = float(np.arcsin(abs(sine)))
    m, wr = order_directions(period_m, wavelength_m, theta)
    return float(_plain(seen, wavelength_m, m, from_angles(theta, np.pi), wr).sum())
