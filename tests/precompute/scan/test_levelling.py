# SPDX-License-Identifier: GPL-3.0-or-later
"""Levelling, clip, crop, fill and refine against closed forms and plain numpy."""

import numpy as np
import pytest

from precompute.errors import ParameterError, SizeLimitError
from precompute.readers import read_scan
from precompute.scan.clipping import clip, crop
from precompute.scan.heightfield import HeightField
from precompute.scan.info import scan_info
from precompute.scan.levelling import level
from precompute.scan.missing import fill_missing
from precompute.scan.resample import refine


def grid(rows, cols):
    return np.meshgrid((np.arange(cols) + 0.5) / cols, (np.arange(rows) + 0.5) / rows)


def patch(heights, missing=None, dx=50e-9, dy=80e-9):
    return HeightField(heights, dx, dy, missing)


def full_design(rows, cols, order):
    x, y = grid(rows, cols)
    terms = [x**i * y**j for i in range(order + 1) for j in range(order + 1 - i)]
    return np.stack([term.ravel() for term in terms], axis=1)


@pytest.mark.parametrize(("method", "order"), [("plane", 1), ("poly2", 2)])
@pytest.mark.parametrize("holes", [0.0, 0.3])
def test_level_is_the_least_squares_fit(method, order, holes):
    rng = np.random.default_rng(5)
    heights = 1e-7 * rng.standard_normal((37, 52)) + 3e-5  # a large offset costs no digits
    missing = rng.random(heights.shape) < holes
    design = full_design(37, 52, order)
    solution = np.linalg.lstsq(design[~missing.ravel()], heights[~missing], rcond=None)[0]
    expected = heights - (design @ solution).reshape(heights.shape)
    result = level(patch(np.where(missing, np.nan, heights), missing), method)
    np.testing.assert_allclose(result.heights[~missing], expected[~missing], atol=1e-17)
    assert abs(result.valid.mean()) < 1e-20
    assert np.isnan(result.heights[missing]).all()
    assert result.processing == ({"step": "level", "method": method},)


def test_poly2_takes_out_tilt_bow_and_saddle_and_leaves_the_structure():
    x, y = grid(200, 240)
    structure = 1e-8 * np.sin(2 * np.pi * 20 * x)
    bow = 1e-6 * (0.3 * x - 0.7 * y + x**2 - 0.4 * y**2 + 0.9 * x * y + 5)
    result = level(patch(structure + bow), "poly2")
    assert np.abs(result.heights - structure).max() < 0.05 * 1e-8


def test_none_changes_nothing():
    field = patch(np.arange(12.0).reshape(3, 4))
    assert level(field, "none") is field


def test_unknown_levelling():
    with pytest.raises(ParameterError, match="none, plane, poly2"):
        level(patch(np.zeros((3, 3))), "cubic")


def test_level_with_too_few_points_does_not_explode():
    heights, missing = np.full((5, 5), np.nan), np.ones((5, 5), bool)
    heights[2, 1:4], missing[2, 1:4] = [1.0, 2.0, 3.0], False
    assert np.abs(level(patch(heights, missing), "poly2").valid).max() < 1e-9


def test_clip_keeps_the_middle_percent():
    heights = np.arange(10001.0).reshape(73, 137) * 1e-9
    result = clip(patch(heights), 99.0)
    assert result.heights.min() == pytest.approx(50e-9)
    assert result.heights.max() == pytest.approx(9950e-9)
    inside = (heights >= 50e-9) & (heights <= 9950e-9)
    np.testing.assert_array_equal(result.heights[inside], heights[inside])
    assert clip(patch(heights), None).processing == ()


@pytest.mark.parametrize("percent", [0.0, -1.0, 100.1, np.nan])
def test_clip_that_makes_no_sense(percent):
    with pytest.raises(ParameterError, match="percent makes no sense"):
        clip(patch(np.zeros((3, 3))), percent)


def test_the_measured_skin_has_a_half_range_of_about_201_nm(scan_dir):
    field = read_scan(scan_dir / "xenopeltis_65um_818.69nm.png", (65e-6, 65e-6), 818.69e-9)
    field = clip(level(field, "poly2"), 99.9)
    assert np.ptp(field.heights) / 2 == pytest.approx(201e-9, abs=1.5e-9)


def test_crop_takes_pixels_by_their_centres():
    field = patch(np.arange(20.0).reshape(4, 5), dx=1e-6, dy=2e-6)
    part = crop(field, x_m=(1.5e-6, 4e-6), y_m=(2e-6, 6e-6))
    np.testing.assert_array_equal(part.heights, field.heights[1:3, 1:4])
    assert part.size_m == pytest.approx((3e-6, 4e-6))
    with pytest.raises(ParameterError, match="leaves 1 of 5 pixels"):
        crop(field, x_m=(1e-6, 2e-6))
    with pytest.raises(ParameterError, match="lower and an upper"):
        crop(field, x_m=(2e-6, 1e-6))


def test_fill_continues_a_tilted_plane_through_holes():
    x, y = grid(61, 47)
    plane = 3.0 + 2.0 * x - 5.0 * y
    missing = np.zeros(plane.shape, bool)
    missing[10:30, 5:25] = missing[-1, -1] = missing[0] = True
    result = fill_missing(patch(np.where(missing, np.nan, plane), missing))
    np.testing.assert_allclose(result.heights, plane, atol=1e-12)
    assert not result.missing.any()
    assert result.processing[-1] == {"step": "fill", "count": 448, "fraction": 448 / (61 * 47)}


def test_fill_keeps_what_was_measured_and_stays_in_its_range():
    rng = np.random.default_rng(2)
    heights = rng.random((50, 40))
    missing = rng.random(heights.shape) < 0.4
    result = fill_missing(patch(np.where(missing, np.nan, heights), missing))
    np.testing.assert_array_equal(result.heights[~missing], heights[~missing])
    assert result.heights.min() > -0.1
    assert result.heights.max() < 1.1
    full = patch(heights)
    assert fill_missing(full) is full


def test_refine_is_exact_for_cubics_up_to_the_edge():
    rows, cols = 12, 9
    field = patch(np.zeros((rows, cols)), dx=267e-9, dy=120e-9)
    x = (np.arange(cols) + 0.5) * field.dx * 1e6
    y = (np.arange(rows) + 0.5) * field.dy * 1e6

    def cubic(x, y):
        return (x**3 - 2 * x**2 + 1)[None, :] * (0.5 * y**3 + y)[:, None]

    result = refine(patch(cubic(x, y), dx=field.dx, dy=field.dy), 95e-9)
    assert result.shape == (rows * 2, cols * 3)
    assert result.size_m == pytest.approx(field.size_m)
    xf = (np.arange(cols * 3) + 0.5) * result.dx * 1e6
    yf = (np.arange(rows * 2) + 0.5) * result.dy * 1e6
    np.testing.assert_allclose(result.heights, cubic(xf, yf), atol=1e-11)
    assert (result.processing[-1]["factor_x"], result.processing[-1]["factor_y"]) == (3, 2)


def test_refine_leaves_fine_pixels_alone():
    field = patch(np.zeros((4, 4)), dx=95e-9, dy=20e-9)
    assert refine(field, 95e-9) is field


def test_refine_converges_at_fourth_order():
    errors = []
    for count in (20, 40, 80):
        step = 4e-6 / count
        centres = (np.arange(count) + 0.5) * step
        fine = refine(patch(np.tile(np.sin(3e6 * centres), (4, 1)), dx=step, dy=1e-9), step / 4 * 1.001)
        xf = (np.arange(fine.shape[1]) + 0.5) * fine.dx
        errors.append(np.abs(fine.heights[0] - np.sin(3e6 * xf)).max())
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12


def test_refine_is_refused_with_the_numbers():
    with pytest.raises(SizeLimitError, match=r"1000 x 2000 nm need 6600 x 3300 pixels"):
        refine(patch(np.zeros((300, 300)), dx=1e-6, dy=2e-6), 95e-9, limit_pixels=6600 * 3300 - 1)


def test_refine_fills_missing_points_first():
    missing = np.zeros((6, 6), bool)
    missing[2, 3] = True
    result = refine(patch(np.where(missing, np.nan, 1.0), missing, dx=190e-9), 95e-9)
    np.testing.assert_allclose(result.heights, 1.0)
    assert [step["step"] for step in result.processing] == ["fill", "refine"]


def test_scan_info_counts_only_what_was_measured():
    heights = np.array([[1.0, 2.0, np.nan], [4.0, 5.0, 6.0]]) * 1e-9
    field = HeightField(heights, 1e-6, 2e-6, np.isnan(heights), {"format": "gsf", "channel": "Z"})
    info = scan_info(field)
    valid = np.array([1, 2, 4, 5, 6]) * 1e-9
    assert info["shape"] == [2, 3]
    assert info["size_m"] == pytest.approx([3e-6, 4e-6])
    assert (info["z_min_m"], info["z_max_m"]) == pytest.approx((1e-9, 6e-9))
    assert info["rms_m"] == pytest.approx(np.sqrt(np.mean((valid - valid.mean()) ** 2)))
    assert (info["missing"], info["channel"], info["format"]) == (1, "Z", "gsf")
