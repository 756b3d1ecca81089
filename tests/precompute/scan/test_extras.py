# SPDX-License-Identifier: GPL-3.0-or-later
"""Row alignment with its warning, smoothing, and patches that tile."""

import numpy as np
import pytest

from precompute.errors import ParameterError
from precompute.presets import make_preset
from precompute.scan.heightfield import HeightField
from precompute.scan.orientation import rotate90
from precompute.scan.row_alignment import align_rows, processing_warnings
from precompute.scan.smoothing import smooth
from precompute.scan.tiling import make_tileable


def test_row_alignment_removes_offsets_of_lines():
    rng = np.random.default_rng(4)
    structure = 1e-9 * rng.standard_normal((64, 90))
    offsets = 20e-9 * rng.standard_normal(64)
    result = align_rows(HeightField(structure + offsets[:, None], 1e-7, 1e-7), "x")
    assert np.abs(result.heights - structure).max() < 1e-9
    assert abs(result.heights.mean()) < 1e-20
    assert processing_warnings(result) == []


def test_row_alignment_along_y_is_the_same_on_the_turned_scan():
    rng = np.random.default_rng(5)
    field = HeightField(rng.standard_normal((40, 30)), 1e-7, 1e-7)
    turned = align_rows(rotate90(field), "y")
    np.testing.assert_allclose(rotate90(turned, -1).heights, align_rows(field, "x").heights, atol=1e-12)


@pytest.mark.parametrize("name", ["sinusoid", "blazed"])
def test_a_grating_along_the_fast_axis_is_erased_and_that_is_told(name):
    grating = rotate90(make_preset(name, size_m=20e-6, pixels=256, period_um=2.5))  # lines run along x
    result = align_rows(grating, "x")
    assert result.heights.std() < 1e-12
    (warning,) = processing_warnings(result)
    assert "removed a period of 2.5 um" in warning


def test_a_grating_across_the_fast_axis_stays_without_a_warning():
    grating = make_preset("sinusoid", size_m=20e-6, pixels=256)
    result = align_rows(grating, "x")
    assert result.heights.std() == pytest.approx(grating.heights.std(), rel=1e-6)
    assert processing_warnings(result) == []


def test_row_alignment_of_the_snake_warns_of_its_rows():
    (warning,) = processing_warnings(align_rows(make_preset("snake", disorder_percent=30.0), "x"))
    assert "um that runs along the lines" in warning


@pytest.mark.parametrize("seed", range(20))
def test_noise_of_lines_is_no_period(seed):
    offsets = np.random.default_rng(seed).standard_normal(512)
    assert processing_warnings(align_rows(HeightField(np.tile(offsets[:, None], (1, 8)), 1e-7, 1e-7))) == []


def test_row_alignment_with_missing_points_and_lines():
    rng = np.random.default_rng(6)
    offsets = rng.standard_normal(20)
    missing = rng.random((20, 31)) < 0.3
    missing[7] = True
    heights = np.where(missing, np.nan, np.tile(offsets[:, None], (1, 31)))
    result = align_rows(HeightField(heights, 1e-7, 1e-7, missing))
    np.testing.assert_allclose(result.valid, 0.0, atol=1e-12)
    np.testing.assert_array_equal(result.missing, missing)


def test_unknown_axis():
    with pytest.raises(ParameterError, match="choose x or y"):
        align_rows(HeightField(np.zeros((4, 4)), 1e-7, 1e-7), "z")


def test_smoothing_damps_a_wave_by_its_gaussian():
    """A wave of frequency f loses exp(-2 (pi f sigma)^2) of its amplitude."""
    field = make_preset("sinusoid", size_m=40e-6, pixels=800, period_um=2.0)
    result = smooth(field, 0.3e-6)
    middle = slice(200, 600)
    expected = field.heights[:, middle] * np.exp(-2 * (np.pi * 0.5e6 * 0.3e-6) ** 2)
    np.testing.assert_allclose(result.heights[:, middle], expected, atol=2e-4 * 50e-9)


def test_smoothing_keeps_missing_points_out():
    missing = np.zeros((30, 30), bool)
    missing[10:15, 10:15] = True
    field = HeightField(np.where(missing, np.nan, 3.0), 1e-7, 1e-7, missing)
    result = smooth(field, 2e-7)
    np.testing.assert_allclose(result.valid, 3.0)
    np.testing.assert_array_equal(result.missing, missing)
    assert smooth(field, 0.0) is field


@pytest.mark.parametrize("sigma", [-1e-7, np.nan, 1e-3])
def test_smoothing_that_makes_no_sense(sigma):
    with pytest.raises(ParameterError, match="makes no sense"):
        smooth(make_preset("flat"), sigma)


def seam(heights, axis):
    """Largest step across the seam relative to the largest inside."""
    lines = np.moveaxis(heights, axis, 0)
    return np.abs(lines[0] - lines[-1]).max() / np.abs(np.diff(lines, axis=0)).max()


def test_blending_closes_the_seam_and_keeps_the_roughness():
    field = make_preset("stam_bumps", size_m=40e-6, pixels=500)
    field = field.processed({}, heights=field.heights + 1e-7 * np.linspace(0, 1, 500)[None, :])
    result = make_tileable(field, "blend", 0.2)
    assert seam(field.heights, 1) > 1.5
    assert result.shape == (400, 400)
    assert max(seam(result.heights, 0), seam(result.heights, 1)) < 1.0
    assert (result.dx, result.dy) == (field.dx, field.dy)
    # The middle of the blended band is as rough as the rest.
    assert result.heights[100:, 40:60].std() == pytest.approx(result.heights[100:, 100:].std(), rel=0.35)


@pytest.mark.parametrize("turns", [0, 1])
def test_a_crop_to_whole_periods_tiles_a_grating(turns):
    grating = rotate90(make_preset("sinusoid", size_m=(21.3e-6, 20e-6), pixels=300, period_um=2.0), turns)
    result = make_tileable(grating, "period")
    side, step = (result.size_m[0], result.dx) if turns == 0 else (result.size_m[1], result.dy)
    assert side / 2e-6 == pytest.approx(round(side / 2e-6), abs=2e-3)
    assert side > 19e-6
    assert step == pytest.approx(71e-9, rel=0.01)
    axis = 1 if turns == 0 else 0
    assert seam(grating.heights, axis) > 3
    assert seam(result.heights, axis) < 1.05


def test_a_crop_needs_a_period():
    with pytest.raises(ParameterError, match="no period to crop to"):
        make_tileable(make_preset("flat"), "period")


def test_unknown_tiling():
    with pytest.raises(ParameterError, match="blend, period"):
        make_tileable(make_preset("flat"), "mirror")
    with pytest.raises(ParameterError, match=r"0\.5"):
        make_tileable(make_preset("flat"), "blend", 0.8)
