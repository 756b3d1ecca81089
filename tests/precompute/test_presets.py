# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets have the dimensions that they promise."""

import numpy as np
import pytest

from precompute.constants import PIXEL_MAX_M
from precompute.errors import ParameterError, SizeLimitError
from precompute.presets import PRESETS, make_preset


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_builds_with_its_defaults(name):
    preset = PRESETS[name]
    field = make_preset(name)
    assert np.isfinite(field.heights).all()
    assert field.size_m == pytest.approx((preset.size_um * 1e-6, preset.size_um * 1e-6))
    assert max(field.dx, field.dy) <= PIXEL_MAX_M
    assert field.processing[0]["parameters"] == {p.name: p.default for p in preset.parameters}
    assert preset.source
    assert preset.description.endswith(".")


@pytest.mark.parametrize("name", PRESETS)
def test_parameters_have_units_and_sane_limits(name):
    for parameter in PRESETS[name].parameters:
        if isinstance(parameter.default, bool):
            continue
        assert parameter.minimum <= parameter.default <= parameter.maximum
        assert parameter.name.endswith(f"_{parameter.unit}") == bool(parameter.unit)
        assert parameter.flag == "--" + parameter.name.replace("_", "-")


@pytest.mark.parametrize("name", PRESETS)
def test_the_same_parameters_give_the_same_bits(name):
    first, second = (make_preset(name, size_m=8e-6) for _ in range(2))
    np.testing.assert_array_equal(first.heights, second.heights)


def test_sinusoid_at_pixel_centres():
    field = make_preset("sinusoid", size_m=8e-6, pixels=100, period_um=2.0, amplitude_nm=50.0)
    x = (np.arange(100) + 0.5) * 80e-9
    np.testing.assert_allclose(field.heights, np.tile(50e-9 * np.sin(2 * np.pi * x / 2e-6), (100, 1)), atol=1e-20)


def test_blazed_rises_to_the_right_and_mirror_reverses_it():
    field = make_preset("blazed", size_m=10e-6, pixels=400, period_um=2.5, depth_nm=300.0)
    j = np.arange(400)
    np.testing.assert_allclose(field.heights[7], 300e-9 * ((j + 0.5) % 100) / 100, rtol=1e-9)
    mirrored = make_preset("blazed", size_m=10e-6, pixels=400, period_um=2.5, depth_nm=300.0, mirror=True)
    np.testing.assert_array_equal(mirrored.heights, field.heights[:, ::-1])


def test_oblong_patches_keep_square_pixels():
    field = make_preset("sinusoid", size_m=(20e-6, 10e-6), pixels=200)
    assert field.shape == (100, 200)
    assert field.dx == pytest.approx(field.dy)


def test_another_size_keeps_the_pixel_size():
    assert make_preset("snake", size_m=13e-6).dx == pytest.approx(make_preset("snake").dx, rel=0.01)


def power(field):
    """Power spectrum in m^2 (its sum is the variance) and its frequencies in 1/um."""
    rows, cols = field.shape
    window = np.outer(np.hanning(rows), np.hanning(cols))
    heights = (field.heights - field.heights.mean()) * window
    spectrum = np.abs(np.fft.fft2(heights)) ** 2
    spectrum *= field.heights.var() / spectrum.sum()
    return spectrum, np.fft.fftfreq(cols, field.dx * 1e6)[None, :], np.fft.fftfreq(rows, field.dy * 1e6)[:, None]


@pytest.mark.parametrize("seed", [1, 2])
def test_snake_has_the_rows_fingers_and_roughness_of_the_skin(seed):
    field = make_preset("snake", seed=seed)
    assert field.heights.std() == pytest.approx(50e-9, rel=0.12)
    spectrum, fx, fy = power(field)
    rows = spectrum * ((np.abs(fx) < 0.5) & (np.abs(fy) > 0.45) & (np.abs(fy) < 0.9))
    assert 1 / ((rows * np.abs(fy)).sum() / rows.sum()) == pytest.approx(1.50, abs=0.05)
    fingers = spectrum * ((np.abs(fx) > 1.3) & (np.abs(fx) < 2.4) & (np.abs(fy) < 2))
    assert 0.50 < 1 / ((fingers * np.abs(fx)).sum() / fingers.sum()) < 0.59
    # Disorder: the orders are spread over many frequencies, no single one holds a tenth of its order's power.
    assert rows.max() < 0.1 * rows.sum()
    assert fingers.max() < 0.02 * fingers.sum()


def test_snake_rises_slowly_to_the_tip_and_falls_off():
    steps = np.diff(make_preset("snake", waviness_nm=0.0, disorder_percent=0.0).heights, axis=0)
    assert -steps.min() > 2 * steps.max()


def test_snake_shows_the_same_skin_at_any_resolution():
    coarse = make_preset("snake", size_m=12e-6, pixels=200)
    fine = make_preset("snake", size_m=12e-6, pixels=600)
    mean = fine.heights.reshape(200, 3, 200, 3).mean(axis=(1, 3))
    assert np.corrcoef(coarse.heights.ravel(), mean.ravel())[0, 1] > 0.97


def test_snake_without_disorder_is_periodic():
    field = make_preset("snake", size_m=(5.6e-6, 15e-6), pixels=140, disorder_percent=0.0, waviness_nm=0.0)
    np.testing.assert_allclose(field.heights[:, 28:112], field.heights[:, 14:98], atol=1e-12)


def test_bad_parameters():
    with pytest.raises(ParameterError, match="There is no preset 'fish'; choose one of"):
        make_preset("fish")
    with pytest.raises(ParameterError, match="has no parameter depth_nm; it has period_um"):
        make_preset("sinusoid", depth_nm=3)
    with pytest.raises(ParameterError, match="give a number from"):
        make_preset("sinusoid", period_um=-1)
    with pytest.raises(ParameterError, match="give a number from"):
        make_preset("sinusoid", period_um="wide")
    with pytest.raises(ParameterError, match="positive side lengths"):
        make_preset("flat", size_m=0)
    with pytest.raises(ParameterError, match="at least 2"):
        make_preset("flat", pixels=1)
    with pytest.raises(SizeLimitError, match="8192"):
        make_preset("flat", pixels=10**6)
