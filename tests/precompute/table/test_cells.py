# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse sums over cells against plain loops, and the divisors that follow from them."""

import numpy as np
import pytest

from precompute.table import cells
from precompute.table.layout import TableLayout

LAYOUT = TableLayout(n_r=20, n_phi=288, n_w=9, r0=0.1, w0=0.4, w_min=0.1, w_max=2.6)
THETAS = np.radians([0.0, 35.0, 70.0, 86.0])
SECTORS, AZIMUTHS = 24, 4
R, WIDTH = np.array([0.0, 0.2, 0.5, 0.9, 1.3, 1.7]), np.array([0.2, 0.2, 0.3, 0.4, 0.4, 0.4])


def plain(light, scale, depth, index, divided, gain):
    """``(thetas, azimuths)`` the sum over all sectors, each of them looked at from each azimuth."""
    delta = 2.0 * np.pi / SECTORS
    out = np.zeros((len(THETAS), AZIMUTHS))
    for i, theta in enumerate(THETAS):
        for j in range(AZIMUTHS):
            for ring, (r, width) in enumerate(zip(R / scale, WIDTH / scale, strict=True)):
                for k in range(SECTORS):
                    alpha = (k + 0.5) * delta - 2.0 * np.pi * j / AZIMUTHS
                    rho = np.hypot(r * np.cos(alpha) + np.sin(theta), r * np.sin(alpha))
                    half = 0.5 * np.hypot(width, r * delta)
                    if rho >= 1.0 + half:
                        continue
                    sine = min(rho, 1.0)
                    cos_i, cos_r = (np.sqrt(1.0 - (x / index) ** 2) for x in (sine, np.sin(theta)))
                    if index > 1.0:
                        inverse = np.clip(0.5 + (1.0 - rho) / (2.0 * half), 0.0, 1.0) / cos_i
                    else:
                        inverse = (np.arcsin(min(rho + half, 1.0)) - np.arcsin(max(rho - half, -1.0))) / (2.0 * half)
                    w = index * (cos_i + cos_r)
                    weight = (0.5 * (r**2 + w**2) / index**2) ** 2 / (cos_r * (w / index) ** 2) * inverse * delta
                    place = LAYOUT.slice_coordinate(np.array(depth * w))
                    lower = min(int(place), LAYOUT.n_w - 2)
                    seen = light[lower, ring, k] * (1.0 - place + lower) + light[lower + 1, ring, k] * (place - lower)
                    weight = weight * float(LAYOUT.gain(depth * w)) if gain else weight
                    out[i, j] += weight * seen / divided(np.arcsin(sine))
    return out


@pytest.mark.parametrize(("index", "gain"), [(1.0, False), (1.0, True), (1.3, False)])
def test_sums_are_those_of_plain_loops(index, gain):
    light = np.random.default_rng(8).random((LAYOUT.n_w, len(R), SECTORS)).astype(np.float32)
    slices, scales = cells.Slices(LAYOUT, gain), (1.0, 0.6)
    r, width = ([each / scale for scale in scales] for each in (R, WIDTH))
    seen = cells.Cells(r, width, SECTORS, THETAS, index)
    # Above 1 at the horizon, and not even growing towards it.
    divisor = np.array([[1.0, 1.03, 1.7, 1.5], [1.0, 1.0, 1.0, 2.5]])
    pairs = cells.folded(light, AZIMUTHS)
    whole = seen.undivided(pairs, slices, 0.8)
    left = seen.left(pairs, slices, 0.8, cells.Divisor(THETAS, divisor))
    for k, scale in enumerate(scales):
        assert whole[k] == pytest.approx(plain(light, scale, 0.8, index, lambda _: 1.0, gain), rel=3e-3)
        for number in (0, 3, 6, 9):

            def divided(theta, k=k, tried=cells.TRIED[number]):
                return max(np.interp(theta, THETAS, divisor[k]), tried)

            expected = plain(light, scale, 0.8, index, divided, gain)
            assert left[k, number] == pytest.approx(expected, rel=5e-3)


def test_a_wide_surface_shows_as_much_alone_as_beside_others():
    """Scales that are looked at together do not change each other's sums."""
    light = cells.folded(np.random.default_rng(9).random((LAYOUT.n_w, len(R), SECTORS)).astype(np.float32), AZIMUTHS)
    slices, divisor = cells.Slices(LAYOUT), cells.Divisor(THETAS, np.ones((1, len(THETAS))))
    both = cells.Cells([R, R[:4] / 0.5], [WIDTH, WIDTH[:4] / 0.5], SECTORS, THETAS, 1.0)
    alone = cells.Cells([R[:4] / 0.5], [WIDTH[:4] / 0.5], SECTORS, THETAS, 1.0)
    assert np.array_equal(both.undivided(light, slices, 1.0)[1], alone.undivided(light, slices, 1.0)[0])
    left = alone.left(light, slices, 1.0, divisor)[0]
    assert left == pytest.approx(left[0] / cells.TRIED[:, None, None], rel=1e-6)


def test_more_viewers_than_are_sorted_at_a_time_are_refused():
    count = cells.MOST_VIEWERS // len(THETAS) + 1
    with pytest.raises(ValueError, match="at most"):
        cells.Cells([R] * count, [WIDTH] * count, SECTORS, THETAS, 1.0)


def test_the_least_divisor_leaves_what_came_in():
    """Of light that a divisor t leaves as much as 1 / max(t, 1.3) of: t = light, where that is more than 1.3."""
    light = np.array([0.4, 1.0, 1.29, 1.5, 4.0, 15.0])
    left = light[:, None] / np.maximum(cells.TRIED, 1.3)
    found = cells.needed(left.T[:, :, None])[:, 0]
    assert found[:3] == pytest.approx(1.0)
    assert found[3:] == pytest.approx(light[3:], rel=1e-6)
    assert cells.needed(np.full((len(cells.TRIED), 1, 1), 50.0)) == pytest.approx(cells.TRIED[-1])
