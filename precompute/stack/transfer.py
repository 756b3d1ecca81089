# SPDX-License-Identifier: GPL-3.0-or-later
"""What thin films on a substrate reflect: the transfer matrix, one wavelength and angle beside the other.

With the admittances ``q_s = n cos(theta)`` and ``q_p = cos(theta) / n`` of each medium, an interface reflects
``r = (q_a - q_b) / (q_a + q_b)``, and a film of thickness d in front of what reflects r' adds the round trip
``exp(2 i delta)``, ``delta = 2 pi n d cos(theta) / lambda``:

    r = (r_ab + r' exp(2 i delta)) / (1 + r_ab r' exp(2 i delta))

from the substrate outwards. This is the product of the characteristic matrices (Born & Wolf, 1.6; Macleod, *Thin-Film
Optical Filters*, 2.6) in the form that never grows: films that absorb much only make the exponential small.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: Smallest cosine that is told from the horizon, where everything reflects.
_LEAST_COS = 1e-7

#: Values a block, and films and faces whose values are kept within one.
_BLOCK, _KEPT = 16384, 24


def reflectance(
    indices: Sequence[np.ndarray], thicknesses_m: Sequence[float], wavelengths_m: np.ndarray, cos_theta: np.ndarray
) -> np.ndarray:
    """Reflectance of unpolarised light.

    Parameters
    ----------
    indices
        Of each medium from the outside in, the outer one first, the substrate last: ``(L,)`` n + ik.
    thicknesses_m
        Of the films between, one less than interfaces.
    wavelengths_m
        ``(L,)``.
    cos_theta
        ``(C,)`` cosines of the angle in the outer medium.

    Returns
    -------
    ndarray
        ``(L, C)`` in [0, 1].
    """
    lam = np.asarray(wavelengths_m, float)
    cos = np.maximum(np.asarray(cos_theta, float), _LEAST_COS)
    found = np.empty((len(lam), len(cos)))
    # Blocks that stay in the processor's cache; what repeats is the same object in each of them.
    rows = max(1, _BLOCK // max(len(cos), 1))
    for low in range(0, len(lam), rows):
        block = slice(low, low + rows)
        cut: dict[int, np.ndarray] = {}
        for index in indices:
            cut.setdefault(id(index), np.asarray(index)[block])
        found[block] = _block([cut[id(index)] for index in indices], thicknesses_m, lam[block], cos)
    return found


def _block(
    indices: Sequence[np.ndarray], thicknesses_m: Sequence[float], wavelengths_m: np.ndarray, cos_theta: np.ndarray
) -> np.ndarray:
    """`reflectance` of a few wavelengths; films and faces that come again are reckoned once."""
    lam, cos = wavelengths_m[:, None], cos_theta[None, :]
    outer = np.asarray(indices[0]).real[:, None]
    # n sin(theta) is the same in every medium (Snell).
    tangential = outer**2 * (1.0 - cos**2)
    media: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def medium(which: int) -> tuple[np.ndarray, np.ndarray]:
        """The admittances of s, which is n cos(theta), and of p."""
        if which == 0:
            along = outer * cos + 0j
            return along, along / outer**2
        key = id(indices[which])
        if key not in media:
            square = np.asarray(indices[which], complex)[:, None] ** 2
            # The principal root travels inwards and fades there.
            along = np.sqrt(square - tangential)
            media[key] = along, along / square
        return media[key]

    keys = [(id(index), thickness) for index, thickness in zip(indices[1:-1], thicknesses_m, strict=True)]
    last = len(indices) - 1
    trips: dict[tuple[int, float], np.ndarray] = {}
    faces: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}

    def trip(which: int) -> np.ndarray:
        """There and back through a film."""
        key = keys[which - 1]
        if key in trips:
            return trips[key]
        turn = np.exp((4j * np.pi * thicknesses_m[which - 1]) / lam * medium(which)[0])
        if len(trips) < _KEPT:
            trips[key] = turn
        return turn

    def face(above: int, below: int) -> tuple[np.ndarray, np.ndarray]:
        """Amplitudes that the face between two media reflects."""
        key = (-1 if above == 0 else id(indices[above]), id(indices[below]))
        if key in faces:
            return faces[key]
        found = tuple((a - b) / (a + b) for a, b in zip(medium(above), medium(below), strict=True))
        if len(faces) < _KEPT:
            faces[key] = found[0], found[1]
        return found[0], found[1]

    s, p = face(last - 1, last)
    for which in range(last - 2, -1, -1):
        turn = trip(which + 1)
        r_s, r_p = face(which, which + 1)
        s, p = s * turn, p * turn
        s, p = (r_s + s) / (1.0 + r_s * s), (r_p + p) / (1.0 + r_p * p)
    return np.clip(0.5 * (_square(s) + _square(p)), 0.0, 1.0)


def _square(amplitude: np.ndarray) -> np.ndarray:
    return amplitude.real**2 + amplitude.imag**2


def fresnel_conductor(n: float | np.ndarray, k: float | np.ndarray, cos_theta: np.ndarray) -> np.ndarray:
    """Reflectance of unpolarised light at a face between air and a medium of index n + ik (Born & Wolf, 14.2).

    Parameters
    ----------
    n, k
        Refractive index and extinction; they broadcast against the cosines.
    cos_theta
        Cosine in the air.
    """
    c = np.clip(np.asarray(cos_theta, float), _LEAST_COS, 1.0)
    square = (np.asarray(n, float) + 1j * np.asarray(k, float)) ** 2
    inside = np.sqrt(square - (1.0 - c**2))
    s, p = (c - inside) / (c + inside), (square * c - inside) / (square * c + inside)
    return 0.5 * (np.abs(s) ** 2 + np.abs(p) ** 2)


def fresnel_exact(n: float | np.ndarray, cos_theta: np.ndarray) -> np.ndarray:
    """Reflectance of unpolarised light at a face between air and a clear medium of index n (Born & Wolf, 1.5.2).

    Parameters
    ----------
    n
        Index of what lies behind the face over that in front; below 1 light may be reflected wholly.
    cos_theta
        Cosine in front of the face; they broadcast.
    """
    c = np.clip(np.asarray(cos_theta, float), 0.0, 1.0)
    inside = np.sqrt(np.maximum(np.asarray(n, float) ** 2 - 1.0 + c**2, 0.0))
    c = np.maximum(c, _LEAST_COS)
    s = ((c - inside) / (c + inside)) ** 2
    p = ((n**2 * c - inside) / (n**2 * c + inside)) ** 2
    return 0.5 * (s + p)
