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

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..table.albedo import SECTORS
from ..table.cells import Cells, Divisor, Slices, folded, needed
from ..table.layout import TableLayout
from ..table.scaled_albedo import BOUND_SLACK
from .series import node_weights
from .transforms import workers

#: Wavelengths, polar angles, azimuths and sectors of the albedos of single wavelengths.
WAVELENGTHS, _THETAS, _AZIMUTHS, _SECTORS = 9, 23, 12, 48

#: The last polar angle (radians).
_THETA_LAST = np.radians(88.0)

#: Rings of frequencies are joined to this width over their radius, where it is more than one step.
_RING = 0.03


def sector_shares(layout: TableLayout, start: int, stop: int) -> tuple[int, np.ndarray]:
    """First sector, and parts of each sector ``(sectors from there, rows)`` that rows start ... stop - 1 make up.

    The sectors are those of `precompute.table.albedo`, equal and half a row before phi = 0.
    """
    edges = np.arange(start, stop + 1) * (min(SECTORS, layout.n_phi) / layout.n_phi)
    low, high = int(edges[0]), int(np.ceil(edges[-1] - 1e-9))
    sectors = np.arange(low, high)[:, None]
    share = np.minimum(edges[1:], sectors + 1) - np.maximum(edges[:-1], sectors)
    return low, np.maximum(share, 0.0).astype(np.float32)


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
    frequencies: np.ndarray,
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
    frequencies
        ``(n_f,)`` evenly spaced from 0, at most 0.8 widths of the lobe apart, 1/m.
    means
        ``(sectors, n_f, n)`` S there, see `sector_shares`.
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
    albedos = Albedos(frequencies, means, nodes, kappa_max, layout, index)
    thetas = np.linspace(0.0, _THETA_LAST, _THETAS)
    least = np.ones(_THETAS)
    if albedo is not None:
        tile = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
        least = np.interp(thetas, tile, albedo.min(axis=0))
    divisor = Divisor(thetas, least[None])
    lam = np.linspace(wavelengths[0], wavelengths[-1], WAVELENGTHS)

    def of_wavelength(wavelength: float) -> np.ndarray:
        at = None if gain is None else np.array([np.interp(wavelength, wavelengths, row) for row in gain])
        return albedos.cells([wavelength], thetas).left(albedos.light(wavelength, at), albedos.slices, 1.0, divisor)[0]

    with ThreadPoolExecutor(workers()) as pool:
        parts = np.stack(list(pool.map(of_wavelength, lam)))  # (lam, tried, theta, phi)
    cap = None
    if capped:
        # The equally steep pair of a slice, inside a lacquer and seen from outside.
        sine = index * np.sqrt(np.maximum(1.0 - (layout.slices / (2.0 * index)) ** 2, 0.0))
        steep = np.arcsin(np.minimum(sine, np.sin(_THETA_LAST)))
        slim = needed(parts).max(-1)  # (lam, theta)
        found = np.array([1.0 / np.interp(steep, thetas, row) for row in slim])
        cap = np.stack([np.interp(wavelengths, lam, column) for column in found.T])
    before = parts[:, 0]
    bound = needed(parts).max(0)  # (thetas, azimuths)
    after = parts[:, 0] / np.maximum(bound, 1.0)
    sky = np.sin(2.0 * thetas)[None, :, None] * np.ones_like(before)
    share = float(((before - after) * sky).sum() / max((before * sky).sum(), 1e-30))
    return Energy(_on_tile(np.where(bound > BOUND_SLACK, bound, 1.0), thetas, layout), cap, share)


def _on_tile(values: np.ndarray, thetas: np.ndarray, layout: TableLayout) -> np.ndarray:
    """``(n_albedo_phi, n_theta)`` from coarse angles: the larger neighbour in azimuth, linear in theta."""
    tile_theta = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
    place = np.arange(layout.n_albedo_phi) * (_AZIMUTHS / layout.n_albedo_phi)
    lower = np.floor(place + 1e-9).astype(int) % _AZIMUTHS
    upper = np.ceil(place - 1e-9).astype(int) % _AZIMUTHS
    around = np.maximum(values[:, lower], values[:, upper])
    return np.stack([np.interp(tile_theta, thetas, column) for column in around.T])


class Albedos:
    """Albedos of single wavelengths, summed over `precompute.table.cells`."""

    def __init__(
        self,
        frequencies: np.ndarray,
        means: np.ndarray,
        nodes: np.ndarray,
        kappa_max: float,
        layout: TableLayout,
        index: float,
        ring: float = _RING,
    ) -> None:
        count = _SECTORS if len(means) % _SECTORS == 0 else len(means)
        means = means.reshape(count, -1, *means.shape[1:]).mean(1)
        # Rings: single frequencies near the peak, more of them where everything but T hardly changes.
        starts, start = [], 0
        while start < len(frequencies):
            starts.append(start)
            start += max(1, round(ring * start))
        step = frequencies[1]
        area = frequencies * step
        area[0] = step**2 / 12.0  # Euler-Maclaurin: r dr has a slope at 0
        self._f = np.add.reduceat(area * frequencies, starts) / np.add.reduceat(area, starts)
        self._width = np.diff(np.append(starts, len(frequencies))) * step
        # (n, rings, sectors), times the ring's area.
        means = np.add.reduceat(means * area[:, None].astype(np.float32), starts, axis=1)
        self._means = np.ascontiguousarray(means.transpose(2, 1, 0))
        self._nodes, self._kappa_max, self._index = nodes, kappa_max, index
        self._layout = layout
        self.slices = Slices(layout)

    def light(self, wavelength: float, gain: np.ndarray | None = None, scale: float = 1.0) -> np.ndarray:
        """``(n_w, rings, half the sectors, azimuths)`` T du dv over the angle of a sector, see `cells.folded`.

        Of the rings that a surface stretched by `scale` or less can send out; a scale and depth move its places alone.

        Parameters
        ----------
        wavelength
            Metres.
        gain
            ``(n_w,)`` factor of T at the slices.
        scale
            The largest.
        """
        weights = node_weights(self._nodes, self._kappa_max, 2.0 * np.pi * self._layout.slices / wavelength)
        if gain is not None:
            weights = weights * gain[:, None]
        lit = self._means[:, : self._reach(wavelength / scale)]
        light = (weights.astype(np.float32) @ lit.reshape(len(lit), -1)).reshape(len(weights), *lit.shape[1:])
        return folded(np.maximum(light, 0.0, out=light), _AZIMUTHS)

    def cells(self, wavelengths: Sequence[float], thetas: np.ndarray) -> Cells:
        """What reaches viewers.

        Parameters
        ----------
        wavelengths
            Metres, over the scales of the surface: longer waves see a surface as they do a smaller one.
        thetas
            ``(n,)`` polar angles of the viewer.
        """
        r = [self._f[: self._reach(each)] * each for each in wavelengths]
        width = [self._width[: len(here)] * each for here, each in zip(r, wavelengths, strict=True)]
        return Cells(r, width, self._means.shape[-1], thetas, self._index)

    def _reach(self, wavelength: float) -> int:
        """How many rings a wavelength sends out."""
        return int(np.searchsorted(self._f * wavelength, 2.0, side="right"))
