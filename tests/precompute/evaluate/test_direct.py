# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference evaluator against plain sums, closed forms and pictures that anyone can check."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import jv

from precompute.errors import ParameterError, ScanError
from precompute.evaluate.direct import DirectEvaluator, direct_f, direct_xyz
from precompute.evaluate.directions import from_angles, uvw
from precompute.evaluate.surface import coherence_area
from precompute.scan.heightfield import HeightField
from tests.truth import plain_sums

NORMAL = np.array([0.0, 0.0, 1.0])
BOTH = pytest.mark.parametrize("ensemble", ["single", "average"])


def rough(rows=20, cols=23, dx=90e-9, dy=80e-9, rms=60e-9, seed=1):
    rng = np.random.default_rng(seed)
    return HeightField(rng.normal(0.0, rms, (rows, cols)), dx, dy)


def ramp(slope_x, slope_y, rows=30, cols=35, step=180e-9):
    x, y = (np.arange(cols) + 0.5) * step, (np.arange(rows) + 0.5) * step
    return HeightField(slope_x * x[None, :] + slope_y * y[:, None], step, step)


@BOTH
def test_equals_the_plain_sum(ensemble):
    field, sigma = rough(), 300e-9
    evaluator = DirectEvaluator(field, sigma, ensemble)
    for u, v, w, wavelength in ((0.0, 0.0, -2.0, 550e-9), (0.31, -0.22, -1.7, 400e-9), (-1.2, 0.7, -0.6, 700e-9)):
        expected = plain_sums.ENSEMBLES[ensemble](field.heights, field.dx, field.dy, sigma, u, v, w, wavelength)
        # The plain mean steps the window by pixels; the evaluator sums all lags. They agree to rounding here.
        assert evaluator.transform(u, v, w, wavelength) == pytest.approx(expected, rel=1e-8)


@BOTH
def test_equals_the_plain_sum_for_windows_wider_than_the_patch(ensemble):
    field, sigma = rough(rows=9, cols=7), 1.5e-6
    expected = plain_sums.ENSEMBLES[ensemble](field.heights, field.dx, field.dy, sigma, 0.2, 0.1, -1.5, 500e-9)
    value = DirectEvaluator(field, sigma, ensemble).transform(0.2, 0.1, -1.5, 500e-9)
    # Windows that stop 6 sigma beyond the patch lose exp(-36) of the sum.
    assert value == pytest.approx(expected, rel=1e-8)


@BOTH
def test_brdf_has_the_published_factor(ensemble):
    field = rough()
    wi, wr = from_angles(0.6, 0.4), from_angles(0.3, 2.5)
    T = plain_sums.ENSEMBLES[ensemble](field.heights, field.dx, field.dy, 300e-9, *-(wi + wr), 500e-9)
    expected = (1 + wi @ wr) ** 2 / (wi[2] * wr[2] * (wi[2] + wr[2]) ** 2) * T
    assert direct_f(field, 300e-9, ensemble, wi, wr, 500e-9) == pytest.approx(expected, rel=1e-8)


@BOTH
@pytest.mark.parametrize("slopes", [(0.15, 0.0), (0.0, 0.15), (-0.1, 0.12)])
def test_a_facet_mirrors_the_light_about_its_own_normal(ensemble, slopes):
    """A ramp that rises to the right, lit from above, throws the light to the *left*."""
    field = ramp(*slopes)
    half = np.array([-slopes[0], -slopes[1], 1.0])
    half /= np.linalg.norm(half)
    mirror = 2 * (half @ NORMAL) * half - NORMAL
    axis = np.linspace(-0.6, 0.6, 25)
    values = np.zeros((axis.size, axis.size))
    evaluator = DirectEvaluator(field, 1e-6, ensemble)
    for j, y in enumerate(axis):
        for i, x in enumerate(axis):
            wr = np.array([x, y, np.sqrt(1 - x * x - y * y)])
            values[j, i] = evaluator.transform(*uvw(NORMAL, wr), 500e-9)
    j, i = np.unravel_index(values.argmax(), values.shape)
    # A step of the grid is 0.05; the lobe is 0.06 wide.
    assert axis[i] == pytest.approx(mirror[0], abs=0.05)
    assert axis[j] == pytest.approx(mirror[1], abs=0.05)
    if slopes[0] > 0:
        assert axis[i] < -0.2


@BOTH
def test_flat_patch_peaks_at_the_coherence_area(ensemble):
    """f = (coherence area) / lambda^2 in every mirror direction, and the area tends to 4 pi sigma^2."""
    sigma, side, wavelength = 1e-6, 40e-6, 600e-9
    field = HeightField(np.zeros((80, 80)), side / 80, side / 80)
    wi = from_angles(np.radians([0.0, 30.0, 60.0]), 0.3)
    wr = wi * [-1, -1, 1]
    values = direct_f(field, sigma, ensemble, wi, wr, wavelength)
    area = coherence_area(field.shape, field.dx, field.dy, sigma, ensemble)
    assert np.allclose(values, area / wavelength**2, rtol=1e-9)
    # The taper's rim lowers the mean by about sigma / side.
    assert area == pytest.approx(4 * np.pi * sigma**2, rel=1e-9 if ensemble == "single" else 0.05)


@pytest.mark.parametrize("degrees", [0.0, 40.0, 60.0])
def test_flat_patch_reflects_everything(degrees):
    """The directional albedo of a flat patch: integral f cos dw = integral f du dv round the mirror direction."""
    sigma, wavelength = 6.5e-6, 550e-9
    field = HeightField(np.zeros((65, 65)), 1e-6, 1e-6)
    wi = from_angles(np.radians(degrees), 0.0)
    lobe = wavelength / (2 * np.pi * np.sqrt(2) * sigma)
    offsets = np.arange(-7, 8) * lobe
    dx, dy = np.meshgrid(offsets, offsets)
    x, y = -wi[0] + dx, -wi[1] + dy
    inside = x**2 + y**2 < 1
    wr = np.stack([x, y, np.sqrt(np.where(inside, 1 - x**2 - y**2, 1))], -1)[inside]
    albedo = direct_f(field, sigma, "average", wi, wr, wavelength).sum() * lobe**2
    assert albedo == pytest.approx(1.0, abs=5e-3)


@BOTH
@pytest.mark.parametrize("w", [-2.0, -1.1, -0.3])
def test_parseval(ensemble, w):
    """integral T du dv over one period lambda/dx x lambda/dy is 1 for any surface, any window."""
    field, wavelength = rough(rows=12, cols=10), 450e-9
    evaluator = DirectEvaluator(field, 250e-9, ensemble)
    rows, cols = field.shape
    du, dv = wavelength / field.dx / cols, wavelength / field.dy / rows
    # T is a trigonometric polynomial with lags below (rows, cols): this many samples integrate it exactly.
    total = sum(evaluator.transform(i * du, j * dv, w, wavelength) for i in range(cols) for j in range(rows))
    assert total * du * dv == pytest.approx(1.0, rel=1e-9)


def test_sinusoid_has_bessel_orders():
    """50 nm amplitude, 2 um period, 550 nm, normal incidence: order m carries J_m(k w_m a)^2."""
    amplitude, period, wavelength = 50e-9, 2e-6, 550e-9
    rows, cols, step, sigma = 4, 480, period / 24, 4e-6
    x = (np.arange(cols) + 0.5) * step
    field = HeightField(np.tile(amplitude * np.sin(2 * np.pi * x / period), (rows, 1)), step, step)
    evaluator = DirectEvaluator(field, sigma, "average")
    lobe = wavelength / (2 * np.pi * np.sqrt(2) * sigma)
    published = {0: 0.48916, 1: 0.22731, 2: 0.015675, 3: 0.00020042}
    dv = wavelength / step / rows
    for m in range(-3, 4):
        w = -(1 + np.sqrt(1 - (m * wavelength / period) ** 2))
        # Order m leaves along sin(theta_r) = m lambda / d, where u = -sin(theta_r).
        u = -m * wavelength / period + np.arange(-6, 7) * lobe
        total = sum(evaluator.transform(a, j * dv, w, wavelength) for a in u for j in range(rows)) * lobe * dv
        expected = jv(m, 2 * np.pi / wavelength * w * amplitude) ** 2
        assert expected == pytest.approx(published[abs(m)], rel=1e-4)
        assert total == pytest.approx(expected, rel=5e-3)


@BOTH
def test_reciprocity(ensemble):
    field = rough(seed=5)
    rng = np.random.default_rng(6)
    wi, wr = (from_angles(rng.uniform(0, 1.3, 6), rng.uniform(0, 6.3, 6)) for _ in range(2))
    there, back = (direct_f(field, 400e-9, ensemble, *pair, 520e-9) for pair in ((wi, wr), (wr, wi)))
    assert np.allclose(there, back, rtol=1e-12)


@BOTH
def test_relative_brdf_is_one_in_the_mirror_of_a_flat_patch(ensemble):
    field = HeightField(np.full((30, 40), 3e-6), 90e-9, 90e-9)
    for wavelength in (400e-9, 700e-9):
        value = direct_f(field, 500e-9, ensemble, NORMAL, NORMAL, wavelength, normalisation="relative")
        assert value == pytest.approx(1.0, rel=1e-9)
    white = direct_xyz(field, 500e-9, ensemble, NORMAL, NORMAL, normalisation="relative")
    # The specular peak of a flat patch is the white of the illuminant: 0.9505, 1, 1.0889 for D65.
    assert np.allclose(white, [0.9505, 1.0, 1.0889], atol=2e-3)


def test_relative_brdf_has_the_factor_of_the_thesis():
    """rho = C <|P|^2>, C = (1 + wi.wr)^2 / ((cos_i + cos_r)^2 cos_r N^2), N the sum of the window."""
    field, sigma, wavelength = rough(), 300e-9, 500e-9
    wi, wr = from_angles(0.7, 0.1), from_angles(0.4, 1.0)
    u, v, w = -(wi + wr)
    x = (np.arange(field.shape[1]) - (field.shape[1] - 1) / 2) * field.dx
    y = (np.arange(field.shape[0]) - (field.shape[0] - 1) / 2) * field.dy
    g = np.exp(-(x[None, :] ** 2 + y[:, None] ** 2) / (2 * sigma**2))
    k = 2 * np.pi / wavelength
    P = (g * np.exp(1j * k * (w * field.heights + u * x[None, :] + v * y[:, None]))).sum()
    expected = (1 + wi @ wr) ** 2 / ((wi[2] + wr[2]) ** 2 * wr[2] * g.sum() ** 2) * abs(P) ** 2
    value = direct_f(field, sigma, "single", wi, wr, wavelength, normalisation="relative")
    assert value == pytest.approx(expected, rel=1e-9)


@BOTH
def test_wavelength_step_is_fine_enough(ensemble):
    """The step chosen by itself agrees with steps of 0.5 nm; the patch is 27 um long."""
    rng = np.random.default_rng(8)
    field = HeightField(rng.normal(0, 50e-9, (6, 300)), 90e-9, 90e-9)
    sigma = field.size_m[0] / 8
    for theta in (0.2, 0.7, 1.2):
        wi, wr = from_angles(0.5, 0.1), from_angles(theta, 0.3)
        fine = direct_xyz(field, sigma, ensemble, wi, wr, step_m=0.5e-9, dtype=np.complex128)
        chosen = direct_xyz(field, sigma, ensemble, wi, wr, dtype=np.complex128)
        assert np.allclose(chosen, fine, rtol=1e-3)
        assert chosen[1] == pytest.approx(fine[1], rel=2e-4)


def test_xyz_is_the_weighted_sum_of_wavelengths():
    from precompute.light.colour import spectral_weights

    field = rough()
    wi, wr = from_angles(0.6, 0.4), from_angles(0.3, 2.5)
    wavelengths, weights = spectral_weights(step_m=20e-9)
    spectrum = [direct_f(field, 300e-9, "average", wi, wr, lam) for lam in wavelengths]
    value = direct_xyz(field, 300e-9, "average", wi, wr, step_m=20e-9)
    assert np.allclose(value, np.array(spectrum) @ weights, rtol=1e-5)


@BOTH
def test_single_precision_is_good_enough(ensemble):
    field = rough(rows=200, cols=180, seed=9)
    wi, wr = from_angles(0.6, 0.4), from_angles([0.3, 1.0], [2.5, 0.2])
    double, single = (
        direct_f(field, 2e-6, ensemble, wi, wr, 400e-9, dtype=dtype) for dtype in (np.complex128, np.complex64)
    )
    assert np.allclose(single, double, rtol=1e-5)


def test_directions_below_the_surface_give_zero():
    field = rough()
    wi = from_angles([0.3, 2.0, 0.3, np.pi / 2], 0.0)
    wr = from_angles([1.8, 0.2, np.pi, 0.1], 1.0)
    values = direct_f(field, 300e-9, "average", wi, wr, 500e-9)
    assert np.array_equal(values[:3], np.zeros(3))
    assert np.isfinite(values).all()


def test_a_common_height_changes_nothing():
    field = rough()
    lifted = HeightField(field.heights + 5e-6, field.dx, field.dy)
    wi, wr = from_angles(0.6, 0.4), from_angles(0.3, 2.5)
    values = [direct_f(f, 300e-9, "average", wi, wr, 500e-9) for f in (field, lifted)]
    assert values[0] == pytest.approx(values[1], rel=1e-9)


def test_bad_input_is_refused():
    holes = np.zeros((4, 4), bool)
    holes[1, 1] = True
    with pytest.raises(ScanError):
        DirectEvaluator(HeightField(np.zeros((4, 4)), 1e-7, 1e-7, missing=holes), 1e-6, "single")
    with pytest.raises(ScanError):
        DirectEvaluator(HeightField(np.zeros((2, 9)), 1e-7, 1e-7), 1e-6, "average")
    for sigma, ensemble in ((0.0, "single"), (np.nan, "single"), (1e-6, "both")):
        with pytest.raises(ParameterError):
            DirectEvaluator(rough(), sigma, ensemble)
    with pytest.raises(ParameterError):
        direct_f(rough(), 1e-6, "single", NORMAL, NORMAL, -500e-9)
    with pytest.raises(ParameterError):
        direct_f(rough(), 1e-6, "single", NORMAL, NORMAL, 500e-9, normalisation="wrong")
