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

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..table.albedo import SECTORS
from ..table.layout import TableLayout
from ..table.scaled_albedo import BOUND_SLACK
from .series import node_weights
from .transforms import workers

#: Wavelengths, polar angles, azimuths and sectors of the albedos of single wavelengths.
WAVELENGTHS, _THETAS, _AZIMUTHS, _SECTORS = 9, 23, 12, 48

#: The last polar angle (radians).
_THETA_LAST = np.radians(88.0)

#: Divisors that are tried; between them the light that is left is interpolated.
_TRIED = np.array([1.0, 1.02, 1.05, 1.1, 1.2, 1.35, 1.6, 2.0, 3.0, 6.0, 20.0])

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
    albedos = Albedos(frequencies, means, nodes, kappa_max, layout, index, albedo)
    lam = np.linspace(wavelengths[0], wavelengths[-1], WAVELENGTHS)
    at_nodes: list[np.ndarray | None] = [None] * len(lam)
    if gain is not None:
        at_nodes = [np.array([np.interp(x, wavelengths, row) for row in gain]) for x in lam]
    with ThreadPoolExecutor(workers()) as pool:
        parts = np.stack(list(pool.map(albedos.parts, lam, at_nodes)))  # (lam, tried, theta, phi)
    if capped:
        # The equally steep pair of a slice, inside a lacquer and seen from outside.
        sine = index * np.sqrt(np.maximum(1.0 - (layout.slices / (2.0 * index)) ** 2, 0.0))
        steep = np.arcsin(np.minimum(sine, np.sin(_THETA_LAST)))
        slim = needed(parts).max(-1)  # (lam, theta)
        found = np.array([1.0 / np.interp(steep, albedos.thetas, row) for row in slim])
        gain = np.stack([np.interp(wavelengths, lam, column) for column in found.T])
    before = parts[:, 0]
    bound = needed(parts).max(0)  # (thetas, azimuths)
    after = parts[:, 0] / np.maximum(bound, 1.0)
    sky = np.sin(2.0 * albedos.thetas)[None, :, None] * np.ones_like(before)
    share = float(((before - after) * sky).sum() / max((before * sky).sum(), 1e-30))
    return Energy(_on_tile(np.where(bound > BOUND_SLACK, bound, 1.0), albedos.thetas, layout), gain, share)


def needed(light: np.ndarray) -> np.ndarray:
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
    part = np.clip((1.0 - 1.0 / more) / np.maximum(1.0 / less - 1.0 / more, 1e-12), 0.0, 1.0)
    return np.where(upper == 0, 1.0, _TRIED[lower] + (_TRIED[upper] - _TRIED[lower]) * part)


def _on_tile(values: np.ndarray, thetas: np.ndarray, layout: TableLayout) -> np.ndarray:
    """``(n_albedo_phi, n_theta)`` from coarse angles: the larger neighbour in azimuth, linear in theta."""
    tile_theta = np.arange(layout.n_theta) * (0.5 * np.pi / (layout.n_theta - 1))
    place = np.arange(layout.n_albedo_phi) * (_AZIMUTHS / layout.n_albedo_phi)
    lower = np.floor(place + 1e-9).astype(int) % _AZIMUTHS
    upper = np.ceil(place - 1e-9).astype(int) % _AZIMUTHS
    around = np.maximum(values[:, lower], values[:, upper])
    return np.stack([np.interp(tile_theta, thetas, column) for column in around.T])


class Albedos:
    """Albedos of single wavelengths.

    What weighs T depends on the azimuth through the cosine of its distance from the viewer's, so that a sector and its
    mirror image are added first, and half the sectors do.
    """

    def __init__(
        self,
        frequencies: np.ndarray,
        means: np.ndarray,
        nodes: np.ndarray,
        kappa_max: float,
        layout: TableLayout,
        index: float,
        albedo: np.ndarray | None,
        ring: float = _RING,
    ) -> None:
        count = _SECTORS if len(means) % _SECTORS == 0 else len(means)
        means = means.reshape(count, -1, *means.shape[1:]).mean(1)
        # Rings: single frequencies near the peak, more of them where everything but T hardly changes.
        starts, start = [], 0
        while start < len(frequencies):
            starts.append(start)
            start += max(1, round(ring * start))
        self._f = frequencies
        self._starts = np.array(starts)
        step = frequencies[1]
        area = frequencies * step
        area[0] = step**2 / 12.0  # Euler-Maclaurin: r dr has a slope at 0
        self._area = area
        # (n, f, sectors), times the ring's share of each frequency's area.
        self._means = np.ascontiguousarray((means * area[:, None].astype(np.float32)).transpose(2, 1, 0))
        self._nodes, self._kappa_max, self._slices, self._index = nodes, kappa_max, layout.slices, index
        self._layout = layout
        self.thetas = np.linspace(0.0, _THETA_LAST, _THETAS)
        # For sectors alpha > 0 and azimuths phi_r: the sector alpha further on, and the one alpha further back.
        shift = (np.arange(_AZIMUTHS) * count) // _AZIMUTHS
        self._half = (count + 1) // 2
        self._ahead = (np.arange(self._half)[:, None] + shift) % count
        self._behind = (count - 1 - np.arange(self._half)[:, None] + shift) % count
        self._delta = 2.0 * np.pi / count
        #: The middle sector of an odd number is its own mirror image.
        self._doubled = np.where(self._ahead == self._behind, np.float32(0.5), np.float32(1.0))
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
        rows = self.light(wavelength, gain).reshape(-1, _AZIMUTHS)
        (cells,) = self.cells(wavelength, self.thetas)
        return cells.left(rows, self.thetas, self._divisor)

    @property
    def n_rings(self) -> int:
        return len(self._starts)

    def light(self, wavelength: float, gain: np.ndarray | None = None, scale: float = 1.0) -> np.ndarray:
        """``(n_w, n_rings, half the sectors, azimuths)`` T du dv over `_delta` of one wavelength and its mirror image.

        Of all rings that a surface stretched by `scale` or less can send out, the others dark; a scale and depth move
        its places alone.
        """
        weights = node_weights(self._nodes, self._kappa_max, 2.0 * np.pi * self._slices / wavelength)
        if gain is not None:
            weights = weights * gain[:, None]
        count, starts = self._reach(wavelength / scale)
        lit = self._means[:, :count]
        light = (weights.astype(np.float32) @ lit.reshape(len(lit), -1)).reshape(len(weights), *lit.shape[1:])
        np.maximum(light, 0.0, out=light)
        light = np.add.reduceat(light, starts, axis=1)  # (n_w, rings, sectors): lambda^2 T du dv / (lambda^2 delta)
        out = np.zeros((len(weights), self.n_rings, self._half, _AZIMUTHS), np.float32)
        out[:, : len(starts)] = (light[:, :, self._ahead] + light[:, :, self._behind]) * self._doubled
        return out

    def _reach(self, wavelength: float) -> tuple[int, np.ndarray]:
        """How many frequencies a wavelength sends out, and the first ones of their rings."""
        count = int(np.searchsorted(self._f * wavelength, 2.0, side="right"))
        return count, self._starts[self._starts < count]

    def cells(self, wavelength: float, thetas: np.ndarray, depths: Sequence[float] = (1.0,)) -> list[Cells]:
        """What reaches viewers, for each depth: ``T'(u, v, w) = s^2 T(s u, s v, q w)``.

        Parameters
        ----------
        wavelength
            Metres, over the scale of the surface: longer waves see a surface as they do a smaller one.
        thetas
            ``(n,)`` polar angles of the viewer.
        depths
            Of the surface.
        """
        n = self._index
        count, starts = self._reach(wavelength)
        area = np.add.reduceat(self._area[:count], starts)
        middle = np.add.reduceat(self._area[:count] * self._f[:count], starts) / area
        width = np.diff(np.append(starts, count)) * self._f[1]
        r = (middle * wavelength)[:, None].astype(np.float32)  # single precision, in which arc sines are quick, will do
        alpha = (np.arange(self._half) + 0.5) * self._delta
        half_extent = (0.5 * np.hypot(width[:, None] * wavelength, r * self._delta)).astype(np.float32)
        sin_r = np.sin(thetas)[:, None, None].astype(np.float32)
        rho = np.sqrt(np.maximum(r**2 + 2.0 * r * sin_r * np.cos(alpha).astype(np.float32) + sin_r**2, 0.0))
        # What lies outside of the horizon is left out: theta, and the place among (rings, half the sectors).
        reached = rho < 1.0 + half_extent
        of_theta, place = np.nonzero(reached.reshape(len(thetas), -1))
        rho = rho[reached]
        r, half_extent = (np.broadcast_to(each, reached.shape)[reached] for each in (r, half_extent))
        cos_r = np.sqrt(1.0 - (np.sin(thetas) / n) ** 2).astype(np.float32)[of_theta]
        inside = np.minimum(rho, 1.0)
        incidence = np.arcsin(inside)
        cos_i = np.sqrt(1.0 - (inside / n) ** 2)
        if n > 1.0:
            inverse = np.clip(0.5 + (1.0 - rho) / (2.0 * half_extent), 0.0, 1.0) / cos_i
        else:
            inverse = np.arcsin(np.minimum(rho + half_extent, 1.0)) - np.arcsin(np.clip(rho - half_extent, -1.0, 1.0))
            inverse /= 2.0 * half_extent
        w = n * (cos_i + cos_r)
        weight = (0.5 * (r**2 + w**2) / n**2) ** 2 / (cos_r * (w / n) ** 2) * inverse * self._delta
        starts = np.searchsorted(of_theta, np.arange(len(thetas)))
        found = []
        for depth in depths:
            position = self._layout.slice_coordinate(depth * w)
            lower = np.minimum(position.astype(int), len(self._slices) - 2)
            above = (weight * (position - lower)).astype(np.float32)
            low = lower * (self.n_rings * self._half) + place
            high = low + self.n_rings * self._half
            found.append(Cells(starts, low, high, weight.astype(np.float32) - above, above, incidence))
        return found


@dataclass(frozen=True)
class Cells:
    """Where the light towards viewers comes from; ``(cells,)`` each, polar angle by polar angle.

    Parameters
    ----------
    starts
        ``(thetas,)`` the first cell of each; every viewer has one, its own mirror image.
    low, high
        Rows of `Albedos.light`, flat but for the azimuths: of the slice below and of the one above.
    below, above
        What their light is weighed by.
    incidence
        Polar angle of the light (radians).
    """

    starts: np.ndarray
    low: np.ndarray
    high: np.ndarray
    below: np.ndarray
    above: np.ndarray
    incidence: np.ndarray

    def left(self, light: np.ndarray, thetas: np.ndarray, divisor: np.ndarray) -> np.ndarray:
        """``(tried, thetas, columns)`` light that is left where all is divided by `_TRIED` at least.

        Parameters
        ----------
        light
            ``(rows, columns)`` of `Albedos.light`.
        thetas, divisor
            ``(n,)`` what light from polar angles is divided by in any case.
        """
        return self._left(*self._light(light, thetas, divisor), range(len(self.starts)))

    def needed(self, light: np.ndarray, thetas: np.ndarray, divisor: np.ndarray) -> np.ndarray:
        """``(thetas, columns)`` least divisors that leave at most 1 of the light, see `left`."""
        seen, least = self._light(light, thetas, divisor)
        undivided = np.add.reduceat(seen / least[:, None], self.starts, axis=0)
        found = np.ones(undivided.shape)
        asking = np.flatnonzero(undivided.max(-1) > 1.0)  # few viewers do
        if len(asking):
            found[asking] = needed(self._left(seen, least, asking))
        return found

    def _light(self, light: np.ndarray, thetas: np.ndarray, divisor: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """``(cells, columns)`` light, and what it is divided by in any case."""
        seen = np.take(light, self.low, axis=0)
        seen *= self.below[:, None]
        above = np.take(light, self.high, axis=0)
        above *= self.above[:, None]
        seen += above
        return seen, np.interp(self.incidence, thetas, divisor).astype(np.float32)

    def _left(self, seen: np.ndarray, least: np.ndarray, asking: Iterable[int]) -> np.ndarray:
        ends = np.append(self.starts[1:], len(seen))
        tried = _TRIED[:, None].astype(np.float32)
        parts = (slice(self.starts[k], ends[k]) for k in asking)
        return np.stack([(1.0 / np.maximum(least[part], tried)) @ seen[part] for part in parts], axis=1)
