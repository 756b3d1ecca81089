# SPDX-License-Identifier: GPL-3.0-or-later
"""No wavelength sends out more light than came in: albedos of single wavelengths, and what follows from them.

The Kirchhoff model does not conserve energy, and the albedo of single wavelengths passes 1 where those of X, Y and Z
do not: a blazed grating's one order comes out at 1.21 of the light. With R = 1 it is

    a_lambda(wr) = integral (1 + wi.wr)^2 / (cos_i cos_r w^2) T_lambda(u, v, w) du dv

A renderer divides f by max(1, A(wi), A(wr)). Light towards grazing directions, where A is large in any case, is divided
there, so that a smaller A(wr) may do than a_lambda itself. With A_xyz, the largest of the albedos in X, Y and Z, the
least t >= 1 with

    integral f_lambda / max(A_xyz(wi), t) cos_i dwi <= 1        at every wavelength

is the *bound*; where it passes 1, A is the larger of A_xyz and it, elsewhere A_xyz.

A bake that is asked for ``energy="capped"`` also sums ``T_lambda(u, v, w) c_lambda(w)``, where ``c = 1 / t`` at the
angle of the two directions of (u, v, w) that are equally steep, ``cos = |w| / 2``, and at the azimuth where that is
least. Of all pairs with this (u, v, w) theirs is the least grazing one; in Littrow mount it is the only one. So each
wavelength is cut by its own excess, not all by that of the worst. c is reciprocal, since it depends on what wi and wr
share, and costs nothing, since it depends on slice and wavelength alone; but the table is then no longer the plain
Kirchhoff integral, which is why that is not the default.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..table.albedo import SECTORS
from ..table.layout import TableLayout
from .intensity import PolarIntensity
from .series import node_weights

#: Wavelengths, polar angles, azimuths and sectors of the albedos of single wavelengths.
_WAVELENGTHS, _THETAS, _AZIMUTHS, _SECTORS = 9, 23, 12, 48

#: The last polar angle (radians).
_THETA_LAST = np.radians(88.0)

#: Bounds up to here are as good as 1: so far the sums over these angles err.
_SLACK = 1.01

#: Divisors that are tried; between them the light that is left is interpolated.
_TRIED = np.array([1.0, 1.02, 1.05, 1.1, 1.2, 1.35, 1.6, 2.0, 3.0, 6.0, 20.0])

#: Angles that go through the transforms at a time.
_ANGLES_A_BLOCK = 96


def sector_intensity(polar: PolarIntensity, coefficients: np.ndarray, layout: TableLayout) -> np.ndarray:
    """``(n_f, n, sectors)`` means of S over equal sectors that start half a row before phi = 0.

    The sectors are those of `precompute.table.albedo`.
    """
    sectors = min(SECTORS, layout.n_phi)
    edges = np.arange(layout.n_phi + 1) * (sectors / layout.n_phi)
    total: np.ndarray | None = None
    for start in range(0, layout.n_phi, _ANGLES_A_BLOCK):
        stop = min(start + _ANGLES_A_BLOCK, layout.n_phi)
        values = polar.polar(coefficients, layout.angles[start:stop])
        low, high = int(edges[start]), int(np.ceil(edges[stop] - 1e-9))
        columns = np.arange(low, high)
        share = np.minimum(edges[start + 1 : stop + 1, None], columns + 1) - np.maximum(
            edges[start:stop, None], columns
        )
        if total is None:
            total = np.zeros((*values.shape[:2], sectors), np.float32)
        total[:, :, low:high] += values @ np.maximum(share, 0.0).astype(np.float32)
    if total is None:
        raise ValueError("a layout without angles")
    return total


@dataclass(frozen=True)
class Energy:
    """What the energy of single wavelengths asks for.

    Parameters
    ----------
    bound
        ``(n_albedo_phi, n_theta)``, at least 1.
    gain
        ``(n_w, L)`` factor of T at the slices and wavelengths of a bake, at most 1; None where nothing is capped.
    share_cut
        Part of the light from an even sky that is cut, mean over the wavelengths.
    """

    bound: np.ndarray
    gain: np.ndarray | None
    share_cut: float


def energy(
    polar: PolarIntensity,
    means: np.ndarray,
    nodes: np.ndarray,
    kappa_max: float,
    layout: TableLayout,
    wavelengths: np.ndarray,
    index: float = 1.0,
    gain: np.ndarray | None = None,
    albedo: np.ndarray | None = None,
    capped: bool = False,
) -> Energy:
    """Bound and cap of a patch.

    Parameters
    ----------
    polar
        Gives the frequencies.
    means
        From `sector_intensity`.
    nodes, kappa_max
        Of the intensities.
    layout
        Of the table.
    wavelengths
        ``(L,)`` of the bake, metres.
    index
        Refractive index of a lacquer over the relief.
    gain
        ``(n_w, L)`` of an earlier call that capped T.
    albedo
        ``(n_albedo_phi, n_theta)`` of X, Y and Z, which the tile holds anyway; None before it is known.
    capped
        Whether T is to be capped too.
    """
    albedos = _Albedos(polar.frequencies, means, nodes, kappa_max, layout, index, albedo)
    lam = np.linspace(wavelengths[0], wavelengths[-1], _WAVELENGTHS)
    at_nodes: list[np.ndarray | None] = [None] * len(lam)
    if gain is not None:
        at_nodes = [np.array([np.interp(x, wavelengths, row) for row in gain]) for x in lam]
    parts = np.stack([albedos.parts(*each) for each in zip(lam, at_nodes, strict=True)])  # (lam, tried, theta, phi)
    if capped:
        # The equally steep pair of a slice, inside a lacquer and seen from outside.
        sine = index * np.sqrt(np.maximum(1.0 - (layout.slices / (2.0 * index)) ** 2, 0.0))
        steep = np.arcsin(np.minimum(sine, np.sin(_THETA_LAST)))
        slim = _needed(parts).max(-1)  # (lam, theta)
        found = np.array([1.0 / np.interp(steep, albedos.thetas, row) for row in slim])
        gain = np.stack([np.interp(wavelengths, lam, column) for column in found.T])
    before = parts[:, 0]
    bound = _needed(parts).max(0)  # (thetas, azimuths)
    after = parts[:, 0] / np.maximum(bound, 1.0)
    sky = np.sin(2.0 * albedos.thetas)[None, :, None] * np.ones_like(before)
    share = float(((before - after) * sky).sum() / max((before * sky).sum(), 1e-30))
    return Energy(_on_tile(np.where(bound > _SLACK, bound, 1.0), albedos.thetas, layout), gain, share)


def _needed(light: np.ndarray) -> np.ndarray:
    """Least divisor that leaves at most 1 of the light.

    Parameters
    ----------
    light
        ``(..., tried, thetas, azimuths)`` what the divisors of `_TRIED` leave.
    """
    left = np.moveaxis(light, -3, -1)
    # The first divisor that is enough; between it and the one before, 1 / light is nearly linear.
    enough = left <= 1.0
    upper = np.where(enough.any(-1), np.argmax(enough, -1), len(_TRIED) - 1)
    lower = np.maximum(upper - 1, 0)
    more, less = (np.take_along_axis(left, k[..., None], -1)[..., 0] for k in (lower, upper))
    part = np.clip((1.0 - 1.0 / more) / np.minimum(1.0 / less - 1.0 / more, -1e-12) * -1.0, 0.0, 1.0)
    return np.where(upper == 0, 1.0, _TRIED[lower] + (_TRIED[upper] - _TRIED[lower]) * part)


def _on_tile(values: np.ndarray, thetas: np.ndarray, layout: TableLayout) -> np.ndarray:
    """``(n_albedo_phi, n_theta)`` from coarse angles: the larger neighbour in azimuth, linear in theta."""
    tile_theta = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
    place = np.arange(layout.n_albedo_phi) * (_AZIMUTHS / layout.n_albedo_phi)
    lower = np.floor(place + 1e-9).astype(int) % _AZIMUTHS
    upper = np.ceil(place - 1e-9).astype(int) % _AZIMUTHS
    around = np.maximum(values[:, lower], values[:, upper])
    return np.stack([np.interp(tile_theta, thetas, column) for column in around.T])


class _Albedos:
    """Albedos of one wavelength after the other."""

    def __init__(
        self,
        frequencies: np.ndarray,
        means: np.ndarray,
        nodes: np.ndarray,
        kappa_max: float,
        layout: TableLayout,
        index: float,
        albedo: np.ndarray | None,
    ) -> None:
        every = 2  # 0.8 widths of the lobe a step: enough for a sum over Gaussians
        self._f = frequencies[::every]
        sectors = means.shape[-1]
        if sectors % _SECTORS == 0:
            means = means.reshape(*means.shape[:2], _SECTORS, -1).mean(-1)
        self._means = np.ascontiguousarray(means[::every].transpose(1, 0, 2))  # (n, f, sectors)
        self._nodes, self._kappa_max, self._slices, self._index = nodes, kappa_max, layout.slices, index
        self._layout = layout
        self.thetas = np.linspace(0.0, _THETA_LAST, _THETAS)
        count = self._means.shape[-1]
        self._shift = (np.arange(_AZIMUTHS) * count) // _AZIMUTHS
        # What light towards a polar angle is divided by in any case.
        self._divisor = np.ones(_THETAS)
        if albedo is not None:
            tile = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
            self._divisor = np.maximum(np.interp(self.thetas, tile, albedo.min(axis=0)), 1.0)

    def parts(self, wavelength: float, gain: np.ndarray | None = None) -> np.ndarray:
        """``(tried, thetas, azimuths)`` light that is left where all is divided by `_TRIED` at least.

        Parameters
        ----------
        wavelength
            Metres.
        gain
            ``(n_w,)`` factor of T at the slices.
        """
        n = self._index
        kappa = 2.0 * np.pi * self._slices / wavelength
        weights = node_weights(self._nodes, self._kappa_max, kappa)
        if gain is not None:
            weights = weights * gain[:, None]
        keep = self._f * wavelength <= 2.0
        r = (self._f[keep] * wavelength)[:, None]
        transform = np.tensordot(weights, self._means[:, keep], 1).astype(np.float32)  # (n_w, f, sectors): lambda^2 T
        count = transform.shape[-1]
        np.maximum(transform, 0.0, out=transform)
        flat = transform.reshape(-1)
        delta = 2.0 * np.pi / count
        alpha = (np.arange(count) + 0.5) * delta
        step = self._f[1] - self._f[0]
        area = self._f[keep][:, None] * step * delta  # du dv / lambda^2
        area[0] = step**2 / 12.0 * delta  # Euler-Maclaurin: r dr has a slope at 0
        half_extent = 0.5 * np.hypot(step * wavelength, r * delta)
        place_f = np.arange(len(r))[:, None] * count
        out = np.empty((len(_TRIED), _THETAS, _AZIMUTHS))
        for t, theta in enumerate(self.thetas):
            sin_r = np.sin(theta)
            rho = np.sqrt(np.maximum(r**2 + 2.0 * r * sin_r * np.cos(alpha) + sin_r**2, 0.0))
            inside = np.minimum(rho, 1.0)
            cos_i, cos_r = np.sqrt(1.0 - (inside / n) ** 2), np.sqrt(1.0 - (sin_r / n) ** 2)
            if n > 1.0:
                inverse = np.clip(0.5 + (1.0 - rho) / (2.0 * half_extent), 0.0, 1.0) / cos_i
            else:
                inverse = np.arcsin(np.minimum(rho + half_extent, 1.0)) - np.arcsin(
                    np.clip(rho - half_extent, -1.0, 1.0)
                )
                inverse /= 2.0 * half_extent
            w = n * (cos_i + cos_r)
            weight = (0.5 * (r**2 + w**2) / n**2) ** 2 / (cos_r * (w / n) ** 2) * inverse * area
            position = self._layout.slice_coordinate(w)
            lower = np.minimum(position.astype(int), len(self._slices) - 2)
            blend = position - lower
            # Below the last slice T goes on like |w|^power.
            scale = np.where(w < self._slices[0], (w / self._slices[0]) ** self._layout.power, 1.0)
            divisor = np.interp(np.arcsin(inside), self.thetas, self._divisor)
            weight = weight * scale
            lit = np.nonzero(weight)
            base = lower[lit] * (len(r) * count) + np.broadcast_to(place_f, weight.shape)[lit]
            low, high = ((weight * (1.0 - blend))[lit]).astype(np.float32), ((weight * blend)[lit]).astype(np.float32)
            divided = (1.0 / np.maximum(divisor[lit][:, None], _TRIED)).astype(np.float32)
            stride = len(r) * count
            for a, shift in enumerate(self._shift):
                # Row phi_r, and the sector whose middle lies alpha further on.
                at = base + (lit[1] + shift) % count
                out[:, t, a] = (low * flat[at] + high * flat[at + stride]) @ divided
        return out
