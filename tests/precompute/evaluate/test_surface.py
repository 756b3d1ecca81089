# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors between T and the BRDF, directions and windows."""

from __future__ import annotations

import numpy as np
import pytest

from precompute.bake import window
from precompute.errors import ParameterError
from precompute.evaluate import surface as b
from precompute.evaluate.directions import disc_directions, from_angles, to_angles, uvw
from precompute.scan.heightfield import HeightField


class Made:
    """A transform whose values can be told by hand: (|u|, |v|, |w|), and an albedo of 2 cos theta."""

    def transform(self, u, v, w):
        assert (w < 0).all()
        return np.stack([np.abs(u), np.abs(v), np.abs(w)], -1)

    def albedo(self, directions):
        return 2 * directions[..., 2]


def test_directions_by_angles_have_the_documented_axes():
    """Azimuth 0 is the tangent, 90 degrees the bitangent; theta is measured from the normal."""
    quarter = np.pi / 2
    assert np.allclose(from_angles([0, quarter, quarter], [1.0, 0, quarter]), [[0, 0, 1], [1, 0, 0], [0, 1, 0]])
    rng = np.random.default_rng(1)
    theta, phi = rng.uniform(0, np.pi, 50), rng.uniform(-np.pi, np.pi, 50)
    assert np.allclose(to_angles(3 * from_angles(theta, phi)), (theta, phi))


def test_uvw_points_against_the_two_directions():
    assert np.allclose(uvw([0.6, 0, 0.8], [0, 0, 1.0]), (-0.6, 0.0, -1.8))


def test_disc_runs_to_the_right_and_up():
    directions, inside = disc_directions(8)
    assert directions.shape == (8, 8, 3)
    assert directions[0, 4, 1] == pytest.approx(-0.875)
    assert directions[4, 7, 0] == pytest.approx(0.875)
    assert not inside[0, 0]
    assert np.allclose(np.linalg.norm(directions, axis=-1), 1)


def test_mirror_of_a_flat_patch_has_the_factor_one():
    wi = from_angles(np.radians([0, 30, 60, 89]), 0.7)
    assert np.allclose(b.geometry_factor(wi, wi * [-1, -1, 1]), 1.0)


def test_geometry_factor_by_hand():
    """wi at 60 degrees, wr the normal: wi.wr = 1/2, so (3/2)^2 / (1/2 * 1 * (3/2)^2) = 2."""
    assert b.geometry_factor(from_angles(np.pi / 3, 1.0), np.array([0, 0, 1.0])) == pytest.approx(2.0)


def test_below_the_surface_nothing_is_reflected_and_nothing_is_nan():
    up, down, opposite = np.array([0, 0.6, 0.8]), np.array([0, 0.6, -0.8]), np.array([0, -0.6, -0.8])
    level = np.array([1.0, 0, 0])
    wi = np.stack([up, down, down, up, level, level, up])
    wr = np.stack([down, up, down, opposite, level, -level, level])
    for values in (b.geometry_factor(wi, wr), b.brdf(Made(), wi, wr, 1.5, True)):
        assert np.array_equal(values, np.zeros_like(values))


def test_fresnel_by_hand():
    assert b.fresnel_r0(1.0, 1.5) == pytest.approx(0.04)
    assert b.schlick(1.0, 0.04) == pytest.approx(0.04)
    assert b.schlick(0.0, 0.04) == pytest.approx(1.0)
    assert b.schlick(0.5, 0.04) == pytest.approx(0.04 + 0.96 / 32)
    wi = from_angles(np.radians([0.0, 60.0]), 0.2)
    # In the mirror direction the half angle is the angle of incidence.
    assert np.allclose(b.reflectance(wi, wi * [-1, -1, 1], 1.5), [0.04, 0.07])
    assert np.allclose(b.reflectance(wi, wi * [-1, -1, 1], 1.5, "exact"), [0.04, 0.0891867], atol=1e-6)
    assert np.allclose(b.reflectance(wi, wi, None), 1.0)
    # n and k: Born & Wolf at normal incidence, ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2), whatever the form.
    for form in b.FORMS:
        assert b.reflectance(wi[:1], wi[:1], 0.2 + 3j, form) == pytest.approx((0.64 + 9) / (1.44 + 9))
    with pytest.raises(ParameterError, match="schlick, exact"):
        b.reflectance(wi, wi, 1.5, "rough")
    with pytest.raises(ParameterError):
        b.fresnel_r0(1.0, -2.0)


def test_brdf_is_the_product_of_its_factors():
    wi, wr = from_angles(np.pi / 3, 0.0), np.array([0, 0, 1.0])
    expected = 2.0 * np.array([np.sin(np.pi / 3), 0.0, 1.5])
    assert np.allclose(b.brdf(Made(), wi, wr), expected)
    r = 0.04 + 0.96 * (1 - np.cos(np.pi / 6)) ** 5
    assert np.allclose(b.brdf(Made(), wi, wr, fresnel=1.5), r * expected)
    r = b.reflectance(wi, wr, 1.5, "exact")
    assert np.allclose(b.brdf(Made(), wi, wr, fresnel=1.5, form="exact"), r * expected)
    # a(wi) = 1, a(wr) = 2: the larger divides.
    assert np.allclose(b.brdf(Made(), wi, wr, energy_conserving=True), expected / 2)
    assert np.allclose(b.brdf(Made(), wr, wi, energy_conserving=True), expected / 2)


def test_brdf_broadcasts():
    wi = from_angles(np.linspace(0, 1.2, 4)[:, None], 0.0)
    wr = from_angles(np.linspace(0, 1.2, 3)[None, :], 1.0)
    assert b.brdf(Made(), wi, wr).shape == (4, 3, 3)


def test_energy_conservation_leaves_dark_directions_alone():
    wi, wr = from_angles(1.2, 0.0), from_angles(1.1, 2.0)  # 2 cos = 0.72 and 0.91
    assert np.allclose(b.brdf(Made(), wi, wr, energy_conserving=True), b.brdf(Made(), wi, wr))


@pytest.mark.parametrize("ensemble", ["single", "average"])
def test_coherence_area_is_the_double_sum(ensemble):
    """Written down as sums over all pairs of pixels of a small patch."""
    from scipy.signal.windows import tukey

    rows, cols, dx, dy, sigma = 11, 14, 90e-9, 80e-9, 300e-9
    x, y = np.meshgrid((np.arange(cols) + 0.5) * dx, (np.arange(rows) + 0.5) * dy)
    x, y = x.ravel(), y.ravel()
    if ensemble == "single":
        g = np.exp(-((x - cols * dx / 2) ** 2 + (y - rows * dy / 2) ** 2) / (2 * sigma**2))
        expected = (g.sum() * dx * dy) ** 2 / ((g**2).sum() * dx * dy)
    else:
        t = np.outer(tukey(rows, 0.2), tukey(cols, 0.2)).ravel()
        lag = np.exp(-((x[:, None] - x) ** 2 + (y[:, None] - y) ** 2) / (4 * sigma**2))
        expected = t @ lag @ t * (dx * dy) ** 2 / ((t**2).sum() * dx * dy)
    assert b.coherence_area((rows, cols), dx, dy, sigma, ensemble) == pytest.approx(expected, rel=1e-12)


def test_relative_colour_puts_the_flat_peak_at_unit_luminance():
    from precompute.light.colour import spectral_weights

    area = 4 * np.pi * 6.5e-6**2
    wavelengths, weights = spectral_weights()
    peak = (area / wavelengths**2) @ weights[:, 1]
    normal = np.array([0, 0, 1.0])
    assert b.relative_colour_factor(normal, normal, area) * peak == pytest.approx(1.0)


def test_relative_factor_is_zero_below_the_surface():
    wi, wr = np.array([[0.6, 0, 0.8], [0.6, 0, -0.8]]), np.array([0, 0, 1.0])
    assert np.allclose(b.relative_factor(wi, wr, 500e-9, 1e-12), [0.8 * 0.25, 0.0])


def test_taper_is_the_tukey_window_of_scipy():
    from scipy.signal.windows import tukey

    for count in (3, 8, 31, 500):
        assert np.allclose(window.taper_axis(count), tukey(count, 0.2), atol=1e-13)


def test_gaussian_window_sits_in_the_middle():
    """Between the two central samples for an even count, on the central sample for an odd one."""
    field = HeightField(np.zeros((5, 6)), 1e-6, 2e-6)
    g = window.gaussian_window(field, 2e-6)
    assert np.allclose(g, g[::-1, ::-1])
    assert g[2, 2] == g[2, 3] == pytest.approx(np.exp(-0.125 / 4))
    assert g[3, 2] / g[2, 2] == pytest.approx(np.exp(-0.5))


def test_default_widths():
    field = HeightField(np.zeros((20, 30)), 1e-6, 2e-6)
    assert window.default_sigma_s(field, "average") == pytest.approx(3e-6)
    assert window.default_sigma_s(field, "single") == pytest.approx(7.5e-6)  # a quarter of the side
    wide = HeightField(np.zeros((80, 80)), 1e-6, 1e-6)
    assert window.default_sigma_s(wide, "single") == pytest.approx(16.25e-6)  # of sunlight
    with pytest.raises(ParameterError):
        window.default_sigma_s(field, "both")
