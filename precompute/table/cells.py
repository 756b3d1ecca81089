# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse sums of the light that viewers see: cells of (u, v), rings by sectors, above the horizon.

    a(wr) = integral (1 + wi.wr)^2 / (cos_i cos_r w^2) T(u, v, w) du dv,    wi_xy = -(u, v) - wr_xy

for a few polar angles of the viewer. What weighs T depends on the azimuth through the cosine of its distance from the
viewer's, so that a sector and its mirror image are added first, and half the sectors do. A stretched surface moves the
rings, ``T'(u, v, w) = s^2 T(s u, s v, q w)``, a deepened one the slices that their light is taken from.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..scipy_kernels import sparse_product
from .layout import TableLayout

#: Steps of |w| in which its place among the slices is looked up.
_STEPS = 2**15

#: Levels of the cosine of the light's polar angle by which cells are sorted.
_LEVELS = 256

#: Viewers, polar angles of all scales together, that are looked from at a time: with their levels they fill 16 bits.
MOST_VIEWERS = 2**16 // _LEVELS

#: Divisors that are tried; between them the light that is left is interpolated.
TRIED = np.array([1.0, 1.02, 1.05, 1.1, 1.2, 1.35, 1.6, 2.0, 3.0, 6.0, 20.0])


def folded(light: np.ndarray, azimuths: int) -> np.ndarray:
    """``(..., half the sectors, azimuths)``: the light of sectors ``(..., sectors)`` and of their mirror images.

    Seen from each of some even azimuths: the sector alpha further on, and the one alpha further back.
    """
    count = light.shape[-1]
    shift = (np.arange(azimuths) * count) // azimuths
    half = (count + 1) // 2
    ahead = (np.arange(half)[:, None] + shift) % count
    behind = (count - 1 - np.arange(half)[:, None] + shift) % count
    pairs = np.take(light, ahead, axis=-1)
    pairs += np.take(light, behind, axis=-1)
    # The middle sector of an odd number is its own mirror image.
    pairs *= np.where(ahead == behind, np.float32(0.5), np.float32(1.0))
    return pairs


class Slices:
    """Where between the slices of a table a |w| lies, looked up at many at a time.

    Parameters
    ----------
    layout
        The table's.
    gain
        Whether light is weighed by what texels are multiplied by, ``|w|^power``.
    """

    def __init__(self, layout: TableLayout, gain: bool = False) -> None:
        w = np.arange(_STEPS + 1) * (layout.w_max / _STEPS)
        position = layout.slice_coordinate(w).astype(np.float32)
        self._position = np.minimum(position, np.nextafter(np.float32(layout.n_w - 1), np.float32(0.0)))
        self._gain = layout.gain(w).astype(np.float32) if gain else None
        self._scale = _STEPS / layout.w_max

    def __call__(self, w: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
        """Slice below, part of the one above, and gain, of float32 ``depth * w``."""
        at = (w * np.float32(depth * self._scale) + np.float32(0.5)).astype(np.intp)
        position = self._position.take(at, mode="clip")
        lower = position.astype(np.int32)
        position -= lower
        return lower, position, None if self._gain is None else self._gain.take(at, mode="clip")


class Divisor:
    """What light from each polar angle is divided by in any case, looked up by the cosine of the angle.

    Parameters
    ----------
    thetas, divisor
        ``(n,)`` polar angles, and ``(scales, n)`` what light from there is divided by, linear between them; at least 1.
    """

    def __init__(self, thetas: np.ndarray, divisor: np.ndarray) -> None:
        levels = np.arccos(np.arange(_LEVELS) / (_LEVELS - 1.0))
        found = np.stack([np.interp(levels, thetas, np.maximum(each, 1.0)) for each in divisor])
        #: ``(scales * _LEVELS,)`` one over the divisor.
        self.inverse = (1.0 / found).astype(np.float32).ravel()
        kind = np.searchsorted(TRIED, found, side="right") - 1  # the last of those tried that it is not less than
        #: First levels of the runs whose divisors lie between the same two of those tried, at all scales.
        self.runs = np.flatnonzero((np.diff(kind, prepend=-1) != 0).any(0))
        above = kind[:, None, self.runs] >= np.arange(len(TRIED))[:, None]
        #: ``(scales, 1, tried, runs)`` share of a run's divided and of its undivided light that a tried divisor leaves.
        self.shares = tuple(
            each.astype(np.float32)[:, None] for each in (above, np.where(above, 0.0, 1.0 / TRIED[:, None]))
        )


class Cells:
    """Cells above the horizon, viewer by viewer: each polar angle at each scale.

    Parameters
    ----------
    r, width
        ``(rings,)`` radius and width of the rings for each scale of the surface; those of a smaller scale may be fewer.
    sectors
        Of a circle.
    thetas
        ``(n,)`` polar angles of the viewer.
    index
        Refractive index of a lacquer over the relief.
    """

    def __init__(
        self, r: Sequence[np.ndarray], width: Sequence[np.ndarray], sectors: int, thetas: np.ndarray, index: float
    ) -> None:
        delta = 2.0 * np.pi / sectors
        half = (sectors + 1) // 2
        self._shape = (len(r), len(thetas))
        if len(r) * len(thetas) > MOST_VIEWERS:
            raise ValueError(f"{len(r) * len(thetas)} viewers; at most {MOST_VIEWERS} are sorted at a time.")
        scale = np.repeat(np.arange(len(r), dtype=np.int32), [len(each) for each in r])
        local = np.concatenate([np.arange(len(each), dtype=np.int32) for each in r])
        extents = [0.5 * np.hypot(w, x * delta) for w, x in zip(width, r, strict=True)]
        half_extent = np.concatenate(extents).astype(np.float32)
        rings = np.concatenate(r).astype(np.float32)  # single precision, in which arc sines are quick, will do
        cosines = np.cos((np.arange(half) + 0.5) * delta).astype(np.float32)
        sine = np.sin(thetas).astype(np.float32)[:, None, None]
        rho = (rings[:, None] * (2.0 * cosines)) * sine
        rho += (rings**2)[:, None]
        rho += sine**2
        # What lies outside of the horizon is left out.
        reached = np.flatnonzero(rho < ((1.0 + half_extent) ** 2)[:, None])
        rho = rho.reshape(-1).take(reached)
        np.maximum(rho, 0.0, out=rho)
        np.sqrt(rho, out=rho)
        inside = np.minimum(rho, np.float32(1.0))
        cosine = np.sqrt(np.float32(1.0) - inside**2)
        of_theta, place = np.divmod(reached.astype(np.int32), np.int32(len(rings) * half))
        ring, alpha = np.divmod(place, np.int32(half))
        key = (scale * np.int32(len(thetas) * _LEVELS)).astype(np.uint16).take(ring)
        key += (of_theta * np.int32(_LEVELS)).astype(np.uint16)
        key += (cosine * np.float32(_LEVELS - 1)).astype(np.uint16)
        # Viewer by viewer, and by what light is divided by: which depends on its polar angle.
        order = np.argsort(key, kind="stable")
        self._key = key.take(order)
        rho, inside = (x.take(order) for x in (rho, inside))
        of_theta, ring, alpha = (x.take(order) for x in (of_theta, ring, alpha))
        #: Among (rings, half the sectors) of the surface as it is not scaled.
        self._place = local.take(ring) * np.int32(half) + alpha
        self._level = (scale * np.int32(_LEVELS)).take(ring) + (self._key & np.uint16(_LEVELS - 1))
        half_extent = half_extent.take(ring)
        n2 = np.float32(index**2)
        cos_i = np.sqrt(np.float32(1.0) - inside**2 / n2)
        cos_r = np.sqrt(1.0 - (np.sin(thetas) / index) ** 2).astype(np.float32).take(of_theta)
        if index > 1.0:  # no infinity: what lies outside the horizon is left out
            inverse = np.clip(0.5 + (1.0 - rho) / (2.0 * half_extent), 0.0, 1.0) / cos_i
        else:
            # 1 / cos_i is integrable but infinite on the rim: its mean over the cell's extent in rho.
            inverse = np.arcsin(np.minimum(rho + half_extent, 1.0))
            inverse -= np.arcsin(np.maximum(rho - half_extent, -1.0))
            inverse /= 2.0 * half_extent
        #: |w| of each cell, of a surface of depth 1.
        self._w = cos_i + cos_r
        self._w *= np.float32(index)
        w2 = self._w**2
        # ((r^2 + w^2) / 2 n^2)^2 / (cos_r (w / n)^2)
        factor = (rings**2).take(ring)
        factor += w2
        np.square(factor, out=factor)
        factor *= inverse
        factor /= w2 * cos_r
        factor *= np.float32(0.25 * delta / n2)
        self._weight = factor

    def undivided(self, light: np.ndarray, slices: Slices, depth: float) -> np.ndarray:
        """``(scales, thetas, columns)`` what reaches the viewers.

        Parameters
        ----------
        light
            ``(n_w, rings, half the sectors, columns)`` float32: T du dv of the sector and of its mirror image over the
            angle of a sector, `folded`.
        slices
            Of the table.
        depth
            Of the surface.
        """
        return self._sum(light, *self._seen(slices, depth), np.zeros(1, int))[:, :, 0]

    def left(self, light: np.ndarray, slices: Slices, depth: float, divisor: Divisor) -> np.ndarray:
        """``(scales, tried, thetas, columns)`` what of it is left where all is divided by `TRIED` at least."""
        lower, part, weight = self._seen(slices, depth)
        less = self._sum(light, lower, part, weight, divisor.runs)
        if divisor.inverse.min() == 1.0:  # nothing is divided in any case
            more = less
        else:
            more = self._sum(light, lower, part, weight * divisor.inverse.take(self._level), divisor.runs)
        above, below = (share @ each for share, each in zip(divisor.shares, (more, less), strict=True))
        return (above + below).transpose(0, 2, 1, 3)

    def _seen(self, slices: Slices, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Slice below, part of the one above, and weight of each cell."""
        lower, part, gain = slices(self._w, depth)
        return lower, part, self._weight if gain is None else self._weight * gain

    def _sum(
        self, light: np.ndarray, lower: np.ndarray, part: np.ndarray, weight: np.ndarray, runs: np.ndarray
    ) -> np.ndarray:
        """``(scales, thetas, runs, columns)`` light of the cells of each run of levels, between the slices."""
        each = np.int32(light.shape[1] * light.shape[2])
        indices = np.empty((len(lower), 2), np.int32)
        np.multiply(lower, each, out=indices[:, 0])
        indices[:, 0] += self._place
        np.add(indices[:, 0], each, out=indices[:, 1])
        weights = np.empty((len(lower), 2), np.float32)
        np.multiply(weight, part, out=weights[:, 1])
        np.subtract(weight, weights[:, 1], out=weights[:, 0])
        first = (np.arange(math.prod(self._shape))[:, None] * _LEVELS + runs).ravel().astype(np.uint16)
        pointers = np.append(2 * np.searchsorted(self._key, first), indices.size).astype(np.int32)
        dense = light.reshape(-1, light.shape[-1])
        rows = sparse_product(indices.reshape(-1), weights.reshape(-1), dense, pointers)
        return rows.reshape(*self._shape, len(runs), -1)


def needed(left: np.ndarray) -> np.ndarray:
    """Least divisor that leaves at most 1 of the light.

    Parameters
    ----------
    left
        ``(..., tried, thetas, azimuths)`` what the divisors of `TRIED` leave.
    """
    left = np.moveaxis(left, -3, -1)
    # The first divisor that is enough; between it and the one before, 1 / light is nearly linear.
    enough = left <= 1.0
    upper = np.where(enough.any(-1), np.argmax(enough, -1), len(TRIED) - 1)
    lower = np.maximum(upper - 1, 0)
    more, less = (np.take_along_axis(left, k[..., None], -1)[..., 0] for k in (lower, upper))
    part = np.clip((1.0 - 1.0 / more) / np.maximum(1.0 / less - 1.0 / more, 1e-12), 0.0, 1.0)
    return np.where(upper == 0, 1.0, TRIED[lower] + (TRIED[upper] - TRIED[lower]) * part)
