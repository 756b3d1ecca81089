# SPDX-License-Identifier: GPL-3.0-or-later
"""The four rounds of transforms against two-dimensional transforms of the whole padded patch by numpy."""

import numpy as np
import pytest

from precompute.bake import transforms
from precompute.bake.intensity import PolarIntensity
from precompute.bake.transforms import Axis
from precompute.bake.window import window_axis
from precompute.constants import KAPPA_MAX
from precompute.scan.heightfield import HeightField


def plainly(field, polar, kappa):
    """``(fine_y, fine_x)`` B-spline coefficients of S by full-size transforms in double precision."""
    x, y = polar.x, polar.y
    h = field.heights - 0.5 * (field.heights.max() + field.heights.min())
    p = np.outer(*polar.window_axes) * np.exp(-1j * kappa * h)
    spectrum = np.fft.ifft2(p, (y.padded, x.padded), norm="forward")
    rows, cols = (np.fft.fftfreq(axis.band, 1.0 / axis.band).astype(int) % axis.padded for axis in (y, x))
    lags = np.fft.fft2(np.abs(spectrum[np.ix_(rows, cols)]) ** 2)
    small = np.zeros((y.fine, x.fine), complex)
    for i in range(-y.cut, y.cut + 1):
        for j in range(-x.cut, x.cut + 1):
            small[i, j] = lags[i, j]
    small *= np.outer(*polar.lag_axes)
    return np.fft.fftshift(np.fft.ifft2(small, norm="forward").real)


@pytest.mark.parametrize("ensemble", ["average", "single", "periodic"])
@pytest.mark.parametrize("series", ["nodes", "chebyshev"])
@pytest.mark.parametrize(
    ("shape", "dx", "dy", "sigma_s"),
    [
        ((72, 50), 48e-9, 60e-9, 0.4e-6),
        ((40, 64), 95e-9, 90e-9, 0.1e-6),  # a band wider than the padded transform, which is periodic
    ],
)
def test_intensities_are_those_of_plain_transforms(ensemble, series, shape, dx, dy, sigma_s):
    heights = np.random.default_rng(8).normal(0.0, 20e-9, shape)
    field = HeightField(heights, dx, dy)
    polar = PolarIntensity(field, sigma_s, ensemble, series, 1e-5)
    kappas = np.array([0.1, 0.6, 0.95, 0.3, 0.5]) * KAPPA_MAX  # more than are interleaved at a time
    found = polar.coefficients(kappas).reshape(polar.y.fine, polar.x.fine, len(kappas))
    for index, kappa in enumerate(kappas):
        expected = plainly(field, polar, kappa)
        error = np.abs(found[..., index] - expected).max() / np.abs(expected).max()
        assert error < (2e-6 if series == "nodes" else 1e-4)


@pytest.mark.parametrize(("padded", "band"), [(220, 120), (72, 180), (308, 720), (100, 100), (512, 540)])
def test_runs_of_the_band(padded, band):
    """They name the places that modular arithmetic names."""
    axis = Axis(10, 1.0, padded, band, 3, 20)
    found = np.full(band, -1)
    for place, source in axis.band_runs():
        assert source.stop <= padded
        found[place] = np.arange(source.start, source.stop)
    assert np.array_equal(found, np.fft.fftfreq(band, 1.0 / band).astype(int) % padded)


def test_polar_points_lie_along_rays():
    """S of a wide flat patch is a Gaussian: its values on the polar grid are those of the formula."""
    sigma_s = 0.5e-6
    polar = PolarIntensity(HeightField(np.zeros((500, 500)), 60e-9, 60e-9), sigma_s, "average")
    angles = np.array([0.0, 0.7, 4.0])
    frequencies = polar.frequencies[:12:2]
    found = polar.polar(polar.coefficients(np.array([0.5 * KAPPA_MAX])), angles, frequencies)
    assert found.shape == (3, 6, 1)
    expected = np.exp(-((2.0 * np.pi * frequencies * sigma_s) ** 2))
    # The taper takes a little of the Gaussian's wings.
    assert found[..., 0] / found[:, :1, 0] == pytest.approx(np.tile(expected, (3, 1)), abs=0.02)


def test_opposite_angles_follow():
    """With the same weights: all the way out, where the grid ends, too."""
    field = HeightField(np.random.default_rng(4).normal(0.0, 50e-9, (120, 90)), 60e-9, 70e-9)
    polar = PolarIntensity(field, 0.6e-6, "average")
    coefficients, angles = polar.coefficients(np.array([0.3, 0.8]) * KAPPA_MAX), np.array([0.0, 0.3, 1.5, 2.9])
    found = polar.polar(coefficients, angles, opposite=True)
    expected = polar.polar(coefficients, np.concatenate([angles, angles + np.pi]))
    assert found == pytest.approx(expected, rel=1e-4, abs=1e-6 * float(expected.max()))


def test_lags_that_wrap_around_hardly_count(monkeypatch):
    """Transforms that are shorter than the patch and its lags give the same intensities, the taper's rim being dim."""
    heights = np.random.default_rng(9).normal(0.0, 60e-9, (300, 340))
    field = HeightField(heights, 60e-9, 55e-9)
    angles, kappa = np.linspace(0.0, 6.0, 13), np.array([0.7 * KAPPA_MAX])

    def seen():
        polar = PolarIntensity(field, 1.7e-6, "average")
        return polar, polar.polar(polar.coefficients(kappa), angles)

    short, found = seen()
    monkeypatch.setattr(transforms, "WRAPPED", 0.0)
    long, expected = seen()
    monkeypatch.setattr(transforms, "WRAPPED", 1e-3)
    _, too_short = seen()
    assert short.x.padded <= 0.9 * long.x.padded
    assert short.y.padded <= 0.9 * long.y.padded
    # What is left is where the square of lags ends, which falls on other lags.
    error, more = (np.median(np.abs(each / expected - 1.0)) for each in (found, too_short))
    assert error < 1.5e-4
    assert more > 3.0 * error


@pytest.mark.parametrize("ensemble", ["average", "single", "periodic"])
def test_the_least_period_keeps_what_may_wrap_around_below_the_limit(ensemble):
    count, cut, step, sigma_s = 200, 130, 50e-9, 1e-6
    window = window_axis(count, step, sigma_s, ensemble)
    own = np.append(np.correlate(window, window, "full")[count - 1 :], np.zeros(2 * count))
    smoothed = ensemble == "average"
    weights = np.exp(-((np.arange(cut + 1) * step / sigma_s) ** 2) / 4.0) if smoothed else np.ones(cut + 1)

    def wrapped(period):
        return (own[period - np.arange(cut + 1)] * weights).max() / own[0]

    least = transforms.least_period(window, cut, step, sigma_s, smoothed)
    assert wrapped(least) <= transforms.WRAPPED
    assert least == count + cut + 1 if ensemble == "periodic" else least < count + cut
    assert wrapped(max(least - 3, count)) > transforms.WRAPPED or least <= count + 1
