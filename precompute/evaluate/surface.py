# SPDX-License-Identifier: GPL-3.0-or-later
"""From the transform T(u, v, w) to a BRDF: geometry, Fresnel reflectance, normalisations.

Absolute BRDF, in 1/sr (Stam, *Diffraction Shaders*, 1999, with his F^2 read as the reflectance R):

    f = R (1 + wi.wr)^2 / (cos_i cos_r w^2) T(u, v, w),     (u, v, w) = -(wi + wr)

Relative BRDF of the thesis (Single 2014, eq. 3.9-3.15), which is 1 in the mirror direction of a flat
patch at normal incidence:

    rho = C <|P|^2>,     C = R / R0 (1 + wi.wr)^2 / (w^2 cos_r N^2)

with N the sum of the coherence window's samples. Since T = <|P|^2> / (A lambda^2), the two differ by a factor.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from ..bake.window import check_ensemble, check_sigma_s, taper_axis, window_axis
from ..errors import ParameterError
from ..stack import fresnel_conductor, fresnel_exact
from .directions import uvw

#: Refractive index of keratin, the stuff of scales and nails; the default of the Fresnel term.
IOR_KERATIN = 1.55


#: Forms of the reflectance of a dielectric: the thesis's approximation, and Fresnel's own formulas.
FORMS = ("schlick", "exact")


class Transform(Protocol):
    """What has T(u, v, w) and the directional albedo, as `precompute.table.table.SpectralTable` has."""

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray) -> np.ndarray: ...

    def albedo(self, directions: np.ndarray) -> np.ndarray: ...


def _divisor(table: Transform, directions: np.ndarray) -> np.ndarray:
    """What conserves energy at every wavelength, where the table knows that."""
    return getattr(table, "conserving_albedo", table.albedo)(np.asarray(directions))


def _lit(wi: np.ndarray, wr: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both cosines, made harmless where a direction is not above the surface, and where both are."""
    cos_i, cos_r = np.broadcast_arrays(wi[..., 2], wr[..., 2])
    lit = (cos_i > 0) & (cos_r > 0)
    return np.where(lit, cos_i, 1.0), np.where(lit, cos_r, 1.0), lit


def geometry_factor(wi: np.ndarray, wr: np.ndarray) -> np.ndarray:
    """``(1 + wi.wr)^2 / (cos_i cos_r w^2)``, 0 where a direction is not above the surface.

    Parameters
    ----------
    wi, wr
        ``(..., 3)`` unit vectors towards the light and the viewer; they broadcast.

    Returns
    -------
    ndarray
        ``(...)`` without unit.
    """
    wi, wr = np.asarray(wi, float), np.asarray(wr, float)
    cos_i, cos_r, lit = _lit(wi, wr)
    dot = (wi * wr).sum(axis=-1)
    return np.where(lit, (1.0 + dot) ** 2 / (cos_i * cos_r * (cos_i + cos_r) ** 2), 0.0)


def refracted(directions: np.ndarray, index: float) -> np.ndarray:
    """Directions inside a clear layer of that index: ``(..., 3)`` unit vectors, still pointing outwards."""
    directions = np.asarray(directions, float)
    inside = directions / index
    inside[..., 2] = np.sqrt(np.maximum(1.0 - inside[..., 0] ** 2 - inside[..., 1] ** 2, 0.0))
    return inside


def lacquer_uvw(wi: np.ndarray, wr: np.ndarray, index: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(u, v, w') of a relief under a clear layer: u and v as in air, ``w' = -n (cos_i' + cos_r')``."""
    u, v, w = uvw(wi, wr)
    if index > 1.0:
        w = -index * (refracted(wi, index)[..., 2] + refracted(wr, index)[..., 2])
    return u, v, w


def lacquer_factor(wi: np.ndarray, wr: np.ndarray, index: float) -> np.ndarray:
    """What T(u, v, w') is multiplied by under a clear layer of index n.

    ``t_i t_r (1 + wi'.wr')^2 / (cos_i' cos_r' (w'/n)^2)`` with the refracted directions and the transmittances t of the
    outer face; the n^2 of the solid angles and that of the wavelength inside cancel. Light that meets the outer face
    from inside and is sent back is left out.

    Parameters
    ----------
    wi, wr
        ``(..., 3)`` unit vectors outside.
    index
        Refractive index n of the layer.

    Returns
    -------
    ndarray
        ``(...)``; 0 where a direction is not above the surface.
    """
    inner = geometry_factor(refracted(wi, index), refracted(wr, index))
    cos_i, cos_r, lit = _lit(np.asarray(wi, float), np.asarray(wr, float))
    through = (1.0 - fresnel_exact(index, cos_i)) * (1.0 - fresnel_exact(index, cos_r))
    return np.where(lit, through * inner, 0.0)


def cos_half(wi: np.ndarray, wr: np.ndarray) -> np.ndarray:
    """Cosine of the angle between either direction and their half vector; ``(...)`` for ``(..., 3)``."""
    dot = (np.asarray(wi, float) * np.asarray(wr, float)).sum(axis=-1)
    return np.sqrt(np.clip(0.5 * (1.0 + dot), 0.0, 1.0))


def fresnel_r0(n1: float, n2: float) -> float:
    """Reflectance of a flat boundary at normal incidence, ``((n1 - n2) / (n1 + n2))^2``."""
    for index in (n1, n2):
        if not (np.isfinite(index) and index > 0):
            raise ParameterError(f"A refractive index of {index:g} makes no sense; use a positive number such as 1.55.")
    return ((n1 - n2) / (n1 + n2)) ** 2


def schlick(cosine: np.ndarray, r0: float) -> np.ndarray:
    """Fresnel reflectance after Schlick (1994), ``R0 + (1 - R0) (1 - cos)^5``."""
    return r0 + (1.0 - r0) * (1.0 - np.asarray(cosine, float)) ** 5


def reflectance(wi: np.ndarray, wr: np.ndarray, fresnel: complex | None, form: str = "schlick") -> np.ndarray:
    """R of unpolarised light at the half angle.

    Parameters
    ----------
    wi, wr
        ``(..., 3)`` unit vectors; they broadcast.
    fresnel
        Refractive index of the material in air; complex n + ik for a conductor, which is always exact. None: R = 1.
    form
        Of a dielectric: ``schlick`` (the thesis, and scripts of 0.1.0) or ``exact`` (the materials' default).

    Raises
    ------
    ParameterError
        For indices and forms that are none.
    """
    cosine = cos_half(wi, wr)
    if form not in FORMS:
        raise ParameterError(f"The Fresnel form '{form}' is not known; choose one of {', '.join(FORMS)}.")
    if fresnel is None:
        return np.ones_like(cosine)
    index = complex(fresnel)
    r0 = fresnel_r0(1.0, index.real)
    if index.imag:
        return fresnel_conductor(index.real, index.imag, cosine)
    return schlick(cosine, r0) if form == "schlick" else fresnel_exact(index.real, cosine)


def conservation(table: Transform, wi: np.ndarray, wr: np.ndarray) -> np.ndarray:
    """``1 / max(1, A(wi), A(wr))``, reciprocal, which keeps the directional albedo at or below 1."""
    return 1.0 / np.maximum(1.0, np.maximum(_divisor(table, wi), _divisor(table, wr)))


def brdf(
    table: Transform,
    wi: np.ndarray,
    wr: np.ndarray,
    fresnel: complex | None = None,
    energy_conserving: bool = False,
    form: str = "schlick",
) -> np.ndarray:
    """The absolute BRDF of a table.

    Parameters
    ----------
    table
        A `precompute.table.table.SpectralTable`. What it says of a stack and of a lacquer counts: the stack's
        reflectance is inside, the lacquer's faces are added here.
    wi, wr
        ``(..., 3)`` unit vectors towards the light and the viewer; they broadcast.
    fresnel
        Refractive index of the material in air, or n + ik; None leaves Fresnel away (R = 1).
    energy_conserving
        Divide by ``max(1, a(wi), a(wr))``. The raw Kirchhoff model is the default here; renderers conserve.
    form
        Of the reflectance of a dielectric, see `reflectance`; ``exact`` is what materials show by default.

    Returns
    -------
    ndarray
        ``(..., 3)`` XYZ in 1/sr; 0 where a direction is not above the surface.

    Raises
    ------
    ParameterError
        If ``fresnel`` is given and the table holds a stack's reflectance already.
    """
    wi, wr = np.broadcast_arrays(np.asarray(wi, float), np.asarray(wr, float))
    index = float(getattr(table, "index", 1.0))
    if fresnel is not None and (index > 1.0 or getattr(table, "has_stack", False)):
        raise ParameterError("The table holds the reflectance of its stack already; leave 'fresnel' out.")
    if index > 1.0:
        factor = lacquer_factor(wi, wr, index)
    else:
        factor = geometry_factor(wi, wr) * reflectance(wi, wr, fresnel, form)
    if energy_conserving:
        factor = factor * conservation(table, wi, wr)
    lit = factor > 0
    # Directions below the surface may have w = 0; look the normal up instead and drop it.
    seen = zip(lacquer_uvw(wi, wr, index), (0.0, 0.0, -2.0), strict=True)
    u, v, w = (np.where(lit, x, harmless) for x, harmless in seen)
    return np.where(lit[..., None], factor[..., None] * table.transform(u, v, w), 0.0)


def coherence_area(shape: tuple[int, int], dx: float, dy: float, sigma_s_m: float, ensemble: str) -> float:
    """``lambda^2 T(0, 0, w)`` of a flat patch in square metres: the height of its specular peak.

    ``single`` and ``periodic`` (g = 1): ``(integral g)^2 / integral g^2``. ``average``: the taper's autocorrelation,
    weighted with the lag Gaussian. With a window it tends to ``4 pi sigma_s^2`` for a patch far larger than sigma_s.

    Parameters
    ----------
    shape
        Rows and columns.
    dx, dy
        Pixel size in metres.
    """
    sigma = check_sigma_s(sigma_s_m)
    area = 1.0
    for count, step in zip(shape, (dy, dx), strict=True):
        if check_ensemble(ensemble) != "average":
            g = window_axis(count, step, sigma, ensemble)
            area *= g.sum() ** 2 / (g @ g) * step
        else:
            t = taper_axis(count)
            lags = np.arange(1 - count, count) * step
            area *= np.correlate(t, t, "full") @ np.exp(-0.25 * (lags / sigma) ** 2) / (t @ t) * step
    return float(area)


def relative_factor(wi: np.ndarray, wr: np.ndarray, wavelength_m: np.ndarray | float, area_m2: float) -> np.ndarray:
    """What the absolute BRDF at one wavelength, with R = 1, is multiplied by to give the relative one: rho / f.

    ``rho = C <|P|^2>`` with C as in the module's head (R / R0 = 1; multiply by it for a real surface), so
    ``rho / f = cos_i lambda^2 / area``, `coherence_area` of the patch being ``N^2 dx^2 dy^2 / A``. Unlike f,
    rho is not reciprocal.

    Parameters
    ----------
    wi, wr
        ``(..., 3)`` unit vectors; the result does not depend on ``wr`` beyond its sign.
    wavelength_m
        Broadcasts against the directions, metres.
    area_m2
        `coherence_area`.
    """
    cos_i, _, lit = _lit(np.asarray(wi, float), np.asarray(wr, float))
    return np.where(lit, cos_i, 0.0) * np.asarray(wavelength_m) ** 2 / area_m2


def relative_colour_factor(wi: np.ndarray, wr: np.ndarray, area_m2: float, illuminant: str = "D65") -> np.ndarray:
    """`relative_factor` for colours of a table, scaled so that the flat patch's specular peak has Y = 1.

    A table is absolute: its colours carry the factor 1 / lambda^2 of the diffraction integral inside the
    wavelength integral. This factor takes it out in luminance only; `precompute.evaluate.direct` with
    ``normalisation="relative"`` takes it out of each wavelength.
    """
    from ..light.colour import spectral_weights

    wavelengths, weights = spectral_weights(illuminant=illuminant)
    mean_inverse_square = (weights[:, 1] / wavelengths**2).sum()
    return relative_factor(wi, wr, mean_inverse_square**-0.5, area_m2)
