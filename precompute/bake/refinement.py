# SPDX-License-Identifier: GPL-3.0-or-later
"""Slices, radii and angles of a table, chosen by the bake's own intensities until its lookups err little enough.

A lookup is linear along slice, radius and angle. The nodes are balanced (`precompute.bake.balance`): where T curves by
the second difference D between neighbours, a node lies D / 12 off and the middle between nodes half as much to the
other side. Both fall with the square of the step, and the intensities are there before the table is: their sum over the
light, at radii and slices around those of a plan and along some planes of incidence, says how large D / 12 is, and so
which step is small enough.

What counts are pairs of directions in a plane of incidence whose value is above `FLOOR` of the largest that the same
light has in that plane: what is darker no eye sees beside it. The error of a pair is that of Y, or the largest of those
of X, Y and Z over the largest of the three, whichever is more; those of the three axes are added up.

Planes run through the normal along the direction that diffracts most, a few widths of the coherence lobe beside it,
along a second direction, along the axes and between them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ..table.layout import TableLayout, near_square_columns
from .intensity import PolarIntensity
from .spectral_sum import RADIAL_STEP, Reflectance, SpectralSum
from .transforms import workers

#: Values below this part of the largest in their plane of incidence do not count.
FLOOR = 1e-3

#: Slices at whose neighbourhood the error is looked at, and the least |w| of them: grazing in and out says little.
_SLICES, _LEAST_W = 8, 0.5

#: Planes beside the strongest direction, in widths of the lobe at r = 1; in radians from it.
_BESIDE, _APART = (2.0, 5.0, 12.0), (0.65, 1.1)

#: One in so many pairs of each plane may err more than is said: isolated ones, beside values that vanish.
_PASSED_OVER = 2e-3

#: Polar angles of the light, and of views, along each plane.
_STEEPEST = math.radians(75.0)
_LIGHTS, _VIEWS = np.linspace(0.0, _STEEPEST, 16), np.linspace(-_STEEPEST, _STEEPEST, 301)

#: What an error of X, Y or Z over the largest of the three counts beside one of Y over Y.
_COLOUR = 0.5

#: Wavelength whose lobe that is, metres.
_REFERENCE_M = 500e-9

#: Part of the error that is aimed at, and how much finer a step may become at a time.
_AIM, _LEAP = 0.88, 2.5

#: Layouts that are looked at, at most.
_ROUNDS = 5

#: Angles that a thread looks at at a time.
_ANGLES_A_TIME = 12

#: Where slices may turn from even to a constant ratio.
_W0 = (0.4, 0.8, 1.6, 4.0)


@dataclass(frozen=True)
class Reached:
    """What a choice of nodes came to.

    Parameters
    ----------
    asked
        Largest error that was asked for, a fraction.
    reached
        Estimate of the largest error.
    slices, radii, angles
        Parts of it: the largest of each axis alone.
    wanted_bytes
        Texels of the table that would have held the error, if this one does not; 0 otherwise.
    """

    asked: float
    reached: float
    slices: float
    radii: float
    angles: float
    wanted_bytes: int = 0

    def to_json(self) -> dict[str, float]:
        """For the sidecar."""
        numbers = {name: round(getattr(self, name), 5) for name in ("asked", "reached", "slices", "radii", "angles")}
        return {**numbers, "wanted_bytes": self.wanted_bytes}


def sentence(error: dict[str, float]) -> str:
    """One sentence for a table that does not hold its error; empty where it does."""
    if error["reached"] <= error["asked"]:
        return ""
    return (
        f"lookups are off by up to {100 * error['reached']:.2g} %, more than the {100 * error['asked']:.2g} % that were"
        f" asked for, which would take about {error['wanted_bytes'] / 1e6:.0f} MB of texels; choose a smaller sigma_s,"
        " or accept a larger error"
    )


def refine(
    polar: PolarIntensity,
    coefficients: np.ndarray,
    nodes: np.ndarray,
    layout: TableLayout,
    light: tuple[np.ndarray, np.ndarray],
    reflectance: Reflectance | None,
    asked: float,
    fits: Callable[[TableLayout], bool],
) -> tuple[TableLayout, Reached]:
    """The layout whose lookups hold an error, and the error.

    Parameters
    ----------
    polar, coefficients, nodes
        Intensities of the patch.
    layout
        As planned; never made coarser.
    light
        Wavelengths ``(L,)`` and weights ``(L, 3)``; steps of some nanometres will do.
    reflectance
        Of the surface's stuff at these wavelengths.
    asked
        Largest error, a fraction.
    fits
        Whether a layout is small enough.
    """
    planned, planes = layout, _planes(polar, coefficients)
    errors = best = _Errors(polar, coefficients, nodes, layout, light, reflectance, planes)
    wanted, aim = 0, _AIM * asked
    for _ in range(_ROUNDS - 1):
        if errors.largest <= asked:
            break
        finer, wanted_layout = _finer(errors, planned, aim, fits)
        wanted = wanted_layout.texel_bytes
        if finer == layout:
            break
        layout = finer
        errors = _Errors(polar, coefficients, nodes, layout, light, reflectance, planes)
        best = min(best, errors, key=lambda each: each.largest)
        if errors.largest < 1.5 * asked:  # close, but other points are looked at every time
            aim *= _AIM
    if best.largest <= asked:
        wanted = 0
    return best.layout, Reached(asked, best.largest, *best.by_axis, wanted_bytes=wanted)


def _planes(polar: PolarIntensity, coefficients: np.ndarray) -> np.ndarray:
    """Azimuths of planes of incidence, radians."""
    step = polar.frequencies[1]
    # Every second frequency along both axes, a lobe apart: where a ridge stands is seen well enough.
    grid = coefficients.reshape(polar.y.fine, polar.x.fine, -1)[::2, ::2, coefficients.shape[1] // 2]
    fy = (np.arange(0, polar.y.fine, 2) - polar.y.fine // 2)[:, None] * polar.y.frequency_step
    fx = (np.arange(0, polar.x.fine, 2) - polar.x.fine // 2) * polar.x.frequency_step
    f2 = fy**2 + fx**2
    power = np.where((f2 > (6.0 * step / RADIAL_STEP) ** 2) & (f2 < polar.frequencies[-4] ** 2), grid, 0.0) ** 2 * f2
    found: list[float] = []
    for _ in range(2):
        row, col = np.unravel_index(int(np.argmax(power)), power.shape)
        found.append(math.atan2(fy[row, 0], fx[col]))
        # Nothing within a sixth of a right angle of the line through it.
        across = fx * math.sin(found[-1]) - fy * math.cos(found[-1])
        power = np.where(across**2 > 0.0625 * f2, power, 0.0)
    width = step / RADIAL_STEP * _REFERENCE_M
    beside = [found[0] + part * width for part in _BESIDE]
    return np.array([0.0, 0.5 * math.pi, *found, *beside, *(found[0] + turn for turn in _APART)])


class _Errors:
    """Errors of the lookups of one layout at slices, radii and planes."""

    def __init__(
        self,
        polar: PolarIntensity,
        coefficients: np.ndarray,
        nodes: np.ndarray,
        layout: TableLayout,
        light: tuple[np.ndarray, np.ndarray],
        reflectance: Reflectance | None,
        planes: np.ndarray,
    ) -> None:
        self.layout = layout
        low = max(1, int(np.searchsorted(layout.slices, _LEAST_W)))
        w = np.linspace(layout.slices[min(low, layout.n_w - 2)], layout.slices[-2], _SLICES)
        #: Middle ones of three slices.
        self.middle = np.unique(np.rint(layout.slice_coordinate(w)).astype(int).clip(1, max(layout.n_w - 2, 1)))
        near = np.unique((self.middle[:, None] + [-1, 0, 1]).clip(0, layout.n_w - 1))
        slices = layout.slices[near]
        total = SpectralSum(
            polar.frequencies, nodes, polar.series.kappa_max, layout.radii, slices, *light, reflectance=reflectance
        )
        step = 2.0 * math.pi / layout.n_phi
        rows = np.unique(np.rint(np.concatenate([planes, planes + math.pi]) / step).astype(int) % layout.n_phi)
        rows = np.unique(np.concatenate([rows, (rows + layout.n_phi // 2) % layout.n_phi]))
        angles = ((rows[:, None] + [-1, 0, 1]) * step).ravel()

        def along(few: np.ndarray) -> np.ndarray:
            return total.apply([polar.polar(coefficients, few, each) for each in total.grids])

        with ThreadPoolExecutor(workers()) as pool:
            parts = [angles[start : start + _ANGLES_A_TIME] for start in range(0, len(angles), _ANGLES_A_TIME)]
            found = np.concatenate(list(pool.map(along, parts)), axis=-1)
        found = found.reshape(layout.n_r, len(near), 3, len(rows), 3)  # radius, slice, XYZ, row, beside
        found = found * (slices**-layout.power)[:, None, None, None]
        at = np.searchsorted(near, self.middle)
        below, middle, above = np.moveaxis(found, -1, 0)
        value = middle[:, at]
        before, after = (np.searchsorted(near, self.middle + side).clip(0, len(near) - 1) for side in (-1, 1))
        second = np.zeros((3, *value.shape), value.dtype)
        second[0] = middle[:, before] + middle[:, after] - 2.0 * value
        second[1, 1:-1] = value[:-2] + value[2:] - 2.0 * value[1:-1]
        second[1, 0] = 2.0 * (value[1].mean(axis=-1, keepdims=True) - value[0])
        second[2] = below[:, at] + above[:, at] - 2.0 * value
        off = np.minimum(second / 12.0, 0.5 * value)
        bright = np.maximum(value.max(axis=2, keepdims=True), 1e-30)
        y = np.maximum(value[:, :, 1:2], 1e-30)
        seen_y = off[:, :, :, 1:2] / y
        colour = _COLOUR * off / bright
        #: ``(3 axes, n_r, slices, rows)`` errors of the nodes, with their sign.
        self.errors = np.concatenate([seen_y, colour], axis=3)
        counts = self._counts(value[:, :, 1], rows)
        self.errors *= counts[:, :, None]
        #: As `_largest` has it.
        self.largest = _largest(_together(self.errors))
        self.step_w = np.gradient(layout.slices)[self.middle]
        self.step_r = np.gradient(layout.radii)

    def _counts(self, y: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """``(n_r, slices, rows)`` whether a value counts: 1 or 0.

        ``y`` is ``(n_r, slices, rows)`` T / |w|^power of Y.
        """
        layout = self.layout
        n = layout.index
        slices = layout.slices[self.middle]
        opposite = np.searchsorted(rows, (rows + layout.n_phi // 2) % layout.n_phi)
        r, w = layout.radii[:, None], slices[None, :]
        value = y * (slices**layout.power)[:, None]
        sine_i, sine_r = np.sin(_LIGHTS)[:, None], np.sin(_VIEWS)[None, :]
        cos_i, cos_r = np.sqrt(1.0 - (sine_i / n) ** 2), np.sqrt(1.0 - (sine_r / n) ** 2)
        s, height = sine_i + sine_r, n * (cos_i + cos_r)
        column = np.rint(layout.column(np.abs(s))).astype(int)
        place = np.interp(height, slices, np.arange(len(slices)))
        lower = np.minimum(place.astype(int), len(slices) - 2) if len(slices) > 1 else np.zeros_like(column)
        part = (place - lower)[..., None]
        upper = np.minimum(lower + 1, len(slices) - 1)
        # (u, v) points away from where s does.
        forward = (1.0 - part) * value[column, lower] + part * value[column, upper]
        along = np.where((s < 0.0)[..., None], forward, forward[..., opposite])
        factor = ((np.abs(s) ** 2 + height**2) / n**2) ** 2 / (height**2 * cos_r)
        peak = (factor[..., None] * along).max(axis=1)  # (lights, rows)
        # The two directions of (r, w) in the plane: half their sum and half their difference, as in a mirror.
        half = np.arctan2(r, w)
        apart = np.hypot(r, w) / (2.0 * n)
        turn = np.arccos(np.minimum(apart, 1.0))
        counts = np.zeros(value.shape)
        for sign in (-1.0, 1.0):
            ti, tr = half + sign * turn, half - sign * turn
            inside = (apart <= 1.0) & (np.maximum(np.abs(ti), np.abs(tr)) < math.asin(math.sin(_STEEPEST) / n))
            theta = np.abs(np.arcsin(np.clip(n * np.sin(ti), -1.0, 1.0)))
            nearest = np.rint(np.interp(theta, _LIGHTS, np.arange(len(_LIGHTS)))).astype(int)
            # Where the light comes from the other side all is turned by half a circle.
            least = np.minimum(peak[nearest], peak[nearest][..., opposite])
            f = ((r**2 + w**2) / n**2) ** 2 / (w**2 * np.maximum(np.cos(tr), 0.1))
            counts = np.maximum(counts, (f[..., None] * value > FLOOR * least) & inside[..., None])
        return counts

    @property
    def by_axis(self) -> tuple[float, float, float]:
        """Largest errors of slices, radii and angles alone."""
        first, second, third = (_largest(_together(each[None])) for each in self.errors)
        return first, second, third


def _together(errors: np.ndarray) -> np.ndarray:
    """Of ``(axes, ...)``: along each axis a lookup lies at a node or, half as much to the other side, between two."""
    high = np.maximum(errors, -0.5 * errors).sum(axis=0)
    low = np.minimum(errors, -0.5 * errors).sum(axis=0)
    return np.maximum(high, -low)


def _largest(errors: np.ndarray) -> float:
    """Of ``(..., rows)``, without the few of each row that `_PASSED_OVER` allows."""
    return max(_without_few(row) for row in errors.reshape(-1, errors.shape[-1]).T)


def _without_few(errors: np.ndarray) -> float:
    """The largest, none of them negative, if one in `_PASSED_OVER` of those that are not zero may be larger."""
    some = errors[errors > 0.0]  # most are zero, and a partition is slow among equals
    if not some.size:
        return 0.0
    place = len(some) - 1 - int(len(some) * _PASSED_OVER)
    return float(np.partition(some, place)[place])


def _finer(
    errors: _Errors, planned: TableLayout, goal: float, fits: Callable[[TableLayout], bool]
) -> tuple[TableLayout, TableLayout]:
    """The layout that should hold the goal, or what fits of it; and the one that should."""
    size = np.abs(errors.errors)
    over_w = np.array([_without_few(size[0][:, each].ravel()) for each in range(size.shape[2])])
    over_r = size[1].max(axis=(1, 2, 3))
    over_phi = _largest(size[2])

    def layout(shares: np.ndarray) -> TableLayout:
        """Steps that leave these errors to the axes."""
        n_w, w0 = _slices(errors, planned, np.sqrt(over_w / shares[0]))
        n_r, r0 = _radii(errors, planned, np.sqrt(over_r / shares[1]))
        finer = min(math.sqrt(over_phi / shares[2]), _LEAP)
        n_phi = max(planned.n_phi, 32 * math.ceil(errors.layout.n_phi * finer / 32))
        return replace(
            planned, n_w=n_w, w0=w0, n_r=n_r, r0=r0, n_phi=n_phi, tile_columns=near_square_columns(n_r, n_phi, n_w)
        )

    def left(candidate: TableLayout) -> np.ndarray:
        """Errors that it should leave."""
        scale_w = (_step(candidate.slices, errors.layout.slices[errors.middle]) / errors.step_w) ** 2
        scale_r = (_step(candidate.radii, errors.layout.radii) / errors.step_r) ** 2
        scaled = errors.errors.astype(np.float32)
        scaled[0] *= scale_w[:, None, None]
        scaled[1] *= scale_r[:, None, None, None]
        scaled[2] *= (errors.layout.n_phi / candidate.n_phi) ** 2
        return scaled

    shares = np.full(3, goal)
    for _ in range(16):
        wanted = layout(shares)
        scaled = left(wanted)
        total = _together(scaled)
        largest = _largest(total)
        if largest <= goal:
            break
        # The axis that does most of it where the error is largest becomes finer.
        worst = np.abs(scaled[:, total >= largest]).mean(axis=1)
        shares[int(np.argmax(worst))] *= 0.8
    chosen, looser = wanted, shares.copy()
    while not fits(chosen) and chosen != planned:
        looser *= 1.1
        chosen = layout(looser) if looser.min() < 1.0 else planned
    return chosen, wanted


def _step(nodes: np.ndarray, at: np.ndarray) -> np.ndarray:
    return np.interp(at, nodes, np.gradient(nodes))


def _slices(errors: _Errors, planned: TableLayout, finer: np.ndarray) -> tuple[int, float]:
    """Number of slices and where they turn even, so that each step is ``finer`` times smaller; the fewest."""
    w = errors.layout.slices[errors.middle]
    steps = errors.step_w / finer.clip(1e-3, _LEAP)
    best = None
    for w0 in _W0:
        reach = math.asinh(planned.w_max / w0) - math.asinh(planned.w_min / w0)
        count = 1 + math.ceil(reach * float((np.sqrt(w**2 + w0**2) / steps).max()))
        if best is None or count < best[0]:
            best = (count, w0)
    assert best is not None
    return best if best[0] > planned.n_w else (planned.n_w, planned.w0)


def _radii(errors: _Errors, planned: TableLayout, finer: np.ndarray) -> tuple[int, float]:
    """The same for radii."""
    r = errors.layout.radii
    steps = errors.step_r / finer.clip(1e-3, _LEAP)
    best = None
    for part in np.geomspace(0.25, 2.0, 13):
        r0 = planned.r0 * float(part)
        count = 1 + math.ceil(math.asinh(r[-1] / r0) * float((np.sqrt(r**2 + r0**2) / steps).max()))
        if best is None or count < best[0]:
            best = (count, r0)
    assert best is not None
    return best if best[0] > planned.n_r else (planned.n_r, planned.r0)
