# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets have the dimensions that they promise."""

from dataclasses import replace

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
def test_the_docs_tell_every_parameter_and_source(root_dir, name):
    text = (root_dir / "docs" / "presets.md").read_text(encoding="utf-8")
    section = text.split(f": `{name}`\n")[1].split("\n## ")[0]
    assert PRESETS[name].source in section
    for parameter in PRESETS[name].parameters:
        default = "off" if parameter.default is False else f"{parameter.default:g}"
        (row,) = [line for line in section.splitlines() if line.startswith(f"| `{parameter.flag}` |")]
        assert f"| {default}" in row
        assert parameter.help in row


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


def strongest(field, low=0.2):
    """Frequency (fx, fy) in 1/um of the strongest peak beyond ``low``."""
    spectrum, fx, fy = power(field)
    spectrum = np.where(np.hypot(fx, fy) > low, spectrum, 0.0)
    row, col = np.unravel_index(np.argmax(spectrum), spectrum.shape)
    return abs(fx[0, col]), abs(fy[row, 0])


@pytest.mark.parametrize(("name", "pitch_um"), [("cd", 1.6), ("dvd", 0.74), ("bluray", 0.32)])
def test_discs_diffract_like_gratings_of_their_track_pitch(name, pitch_um):
    field = make_preset(name)
    fx, fy = strongest(field)
    assert 1 / fx == pytest.approx(pitch_um, rel=0.02)
    assert fy < 0.1


@pytest.mark.parametrize(("name", "clock_um", "shortest", "longest"), [("cd", 0.278, 3, 11), ("dvd", 0.133, 3, 11)])
def test_pits_and_lands_are_whole_clock_periods_long(name, clock_um, shortest, longest):
    field = make_preset(name, size_m=(2 * 1.6e-6, 60e-6), pixels=320)
    track = (
        field.heights[:, int(0.5 * PRESETS[name].parameters[0].default * 1e-6 / field.dx)] > 0.5 * field.heights.max()
    )
    edges = np.flatnonzero(np.diff(track.astype(int))) * field.dy
    clocks = np.diff(edges) * 1e6 / clock_um
    np.testing.assert_allclose(clocks, np.rint(clocks), atol=0.25)
    assert np.rint(clocks).min() == shortest
    assert np.rint(clocks).max() <= longest


def test_foil_has_two_gratings_at_the_crossing_angle():
    spectrum, fx, fy = power(make_preset("foil", crossing_deg=60.0))
    angle = np.radians(60.0)
    for kx, ky in ((1.0, 0.0), (np.cos(angle), np.sin(angle))):
        order = spectrum[np.hypot(fx - kx, fy - ky) < 0.08].sum() + spectrum[np.hypot(fx + kx, fy + ky) < 0.08].sum()
        assert order == pytest.approx(0.5 * spectrum.sum(), rel=0.02)


def test_brushed_metal_is_rough_across_and_smooth_along():
    field = make_preset("brushed_metal", seed=3)
    across = np.diff(field.heights, axis=1).std() / field.dx
    along = np.diff(field.heights, axis=0).std() / field.dy
    assert across > 20 * along


def test_grooves_of_one_grain_stand_at_their_distance():
    """Beside the scratches a band about one period, with the variance asked for; without height nothing changes."""
    one = {"scratch_length_um": 6.0, "edges_um": 1.2}  # many grains on the patch
    plain, grooved = (make_preset("brushed_metal", **one, edges_rms_nm=rms) for rms in (0.0, 50.0))
    np.testing.assert_array_equal(plain.heights, make_preset("brushed_metal", scratch_length_um=6.0).heights)
    waves = replace(grooved, heights=grooved.heights - plain.heights)
    assert 1 / strongest(waves, low=0.3)[0] == pytest.approx(1.2, rel=0.1)
    assert waves.heights.std() == pytest.approx(50e-9, rel=0.15)


def test_morpho_ridges_stand_at_their_distance():
    assert 1 / strongest(make_preset("morpho", irregularity_nm=0.0), low=1.0)[0] == pytest.approx(0.7, rel=0.02)


def test_bumps_have_the_moments_of_a_poisson_field():
    """Campbell: mean = n int b, variance = n int b^2, for b = h (1 - r^2)^2 on an ellipse."""
    field = make_preset("stam_bumps", size_m=130e-6, pixels=1024, length_um=1.6, width_um=1.0, height_nm=100.0)
    area = np.pi * 0.8 * 0.5
    assert field.heights.mean() == pytest.approx(0.2 * 100e-9 * area / 3, rel=0.05)
    assert field.heights.var() == pytest.approx(0.2 * 1e-14 * area / 5, rel=0.08)


def test_elaphe_has_columns_of_its_width():
    spectrum, fx, fy = power(make_preset("elaphe"))
    fingers = spectrum * ((np.abs(fx) > 0.65) & (np.abs(fx) < 1.4) & (np.abs(fy) < 1))
    assert 1.0 < 1 / ((fingers * np.abs(fx)).sum() / fingers.sum()) < 1.13


def figures_of_the_scan(field):
    """Of the sum of Y over the x order the part near its middle line, the largest Y there, the light of the y sector.

    R = 1, light from above, on a disc of 400 x 400 direction cosines.
    """
    from precompute.bake import bake
    from precompute.evaluate import brdf
    from precompute.parameters import BakeParameters

    table = bake(field, BakeParameters(sigma_s_m=6.5e-6, error=1.0))
    x, y = np.meshgrid(*[(np.arange(400) + 0.5) / 200 - 1.0] * 2)
    inside = x**2 + y**2 < 1.0
    x, y = x[inside], y[inside]
    seen = brdf(table, np.array([0.0, 0.0, 1.0]), np.stack([x, y, np.sqrt(1.0 - x**2 - y**2)], -1))[:, 1]
    order = (np.abs(x) > 0.35) & (np.abs(x) < 0.75) & (np.abs(y) < 0.4)
    r = np.hypot(x, y)
    sector = (np.abs(y) > np.abs(x)) & (r > 0.2) & (r < 0.55)
    share = seen[order & (np.abs(y) < 0.02)].sum() / seen[order].sum()
    return share, seen[order].max(), seen[sector].sum() / 200**2


def test_elaphe_spreads_its_light_as_its_scan():
    """Of the 65 um scan: 71 %, 25.5 / sr, 0.013 of the light; heights of 434.7 nm. 12 %, 2.7 and 0.037 in 0.1.0."""
    field = make_preset("elaphe")
    share, largest, sector = figures_of_the_scan(field)
    assert share == pytest.approx(0.71, rel=0.08)
    assert largest == pytest.approx(25.5, rel=0.1)
    assert sector == pytest.approx(0.013, rel=0.2)
    assert np.ptp(field.heights) == pytest.approx(434.7e-9, rel=0.05)


def test_elaphe_of_0_1_0_is_still_there():
    """Its figures, by name of its parameters."""
    old = {"row_period_um": 4.0, "height_nm": 120.0, "waviness_nm": 45.0, "disorder_percent": 100.0}
    share, largest, sector = figures_of_the_scan(make_preset("elaphe", alignment_percent=0.0, **old))
    assert (share, largest) == (pytest.approx(0.12, abs=0.01), pytest.approx(2.7, rel=0.05))
    assert sector == pytest.approx(0.037, rel=0.05)
