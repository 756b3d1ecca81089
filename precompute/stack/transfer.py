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
    lam = np.asarray(wavelengths_m, float)[:, None]
    cos = np.maximum(np.asarray(cos_theta, float), _LEAST_COS)[None, :]
    outer = np.asarray(indices[0]).real[:, None]
    # n sin(theta) is the same in every medium (Snell).
    tangential = outer**2 * (1.0 - cos**2)
    done: dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def medium(index: np.ndarray, which: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """n cos(theta) and the admittances of s and p; a material that comes again is reckoned once."""
        if which == 0:
            along = outer * cos + 0j
        elif id(index) in done:
            return done[id(index)]
        else:
            # The principal root travels inwards and fades there.
            along = np.sqrt(np.asarray(index, complex)[:, None] ** 2 - tangential)
        found = along, along, along / np.asarray(index, complex)[:, None] ** 2
        if which:
            done[id(index)] = found
        return found

    below = medium(indices[-1], len(indices) - 1)
    reflected: list[np.ndarray | None] = [None, None]
    for which in range(len(indices) - 2, -1, -1):
        here = medium(indices[which], which)
        for polarisation in (0, 1):
            above, under = here[1 + polarisation], below[1 + polarisation]
            r = (above - under) / (above + under)
            inner = reflected[polarisation]
            if inner is not None:
                turn = inner * np.exp((4j * np.pi * thicknesses_m[which]) / lam * below[0])
                r = (r + turn) / (1.0 + r * turn)
            reflected[polarisation] = r
        below = here
    s, p = (np.abs(r) ** 2 for r in reflected if r is not None)
    return np.clip(0.5 * (s + p), 0.0, 1.0)


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
