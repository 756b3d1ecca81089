# SPDX-License-Identifier: GPL-3.0-or-later
"""The baked table against the reference evaluator and closed forms."""

import json

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d
from scipy.special import jv

from precompute.bake.baking import bake, bake_file
from precompute.errors import Cancelled, ParameterError, SizeLimitError
from precompute.evaluate.direct import direct_xyz
from precompute.evaluate.surface import brdf, geometry_factor
from precompute.light.colour import spectral_weights
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.readers import read_scan
from precompute.scan.heightfield import HeightField
from precompute.scan.preparation import prepare


def directions(count, seed, degrees=70.0):
    """Light and view directions, polar angles uniform in 0 ... degrees."""
    rng = np.random.default_rng(seed)
    theta = np.radians(rng.uniform(0, degrees, (2, count)))
    phi = rng.uniform(0, 2 * np.pi, (2, count))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def table_error(patch, parameters, table, pairs, dtype=np.complex128):
    """Relative errors of Y against the reference evaluator."""
    wi, wr = pairs
    sigma_s = table.info["parameters"]["sigma_s_m"]
    truth = direct_xyz(patch, sigma_s, parameters.ensemble, wi, wr, dtype=dtype)
    return np.abs(brdf(table, wi, wr)[..., 1] / truth[..., 1] - 1)


@pytest.fixture(scope="module")
def snake():
    return make_preset("snake", size_m=30e-6, pixels=480)


@pytest.fixture(scope="module")
def snake_table(snake):
    return bake(snake, BakeParameters())


def test_table_equals_the_reference(snake, snake_table):
    error = table_error(prepare(snake, BakeParameters()), BakeParameters(), snake_table, directions(40, 2))
    assert np.median(error) <= 0.005
    assert np.percentile(error, 95) <= 0.025


def test_single_window_table_equals_the_reference(snake):
    parameters = BakeParameters(ensemble="single", sigma_s_m=4e-6)
    error = table_error(prepare(snake, parameters), parameters, bake(snake, parameters), directions(25, 3))
    assert np.median(error) <= 0.01
    assert np.percentile(error, 95) <= 0.05


@pytest.mark.parametrize("series", ["taylor", "chebyshev"])
def test_series_bake_the_same_table(snake, snake_table, series):
    table = bake(snake, BakeParameters(series=series, tolerance=1e-4))
    wi, wr = directions(200, 4)
    assert brdf(table, wi, wr) == pytest.approx(brdf(snake_table, wi, wr), rel=5e-3)
    assert table.info["terms"] > 1


def test_colours_lie_where_the_grating_equation_puts_them():
    """A sinusoid along x, light from above: order 1 of wavelength lambda leaves at sin(theta) = lambda / period."""
    table = bake(make_preset("sinusoid", size_m=40e-6, pixels=500, period_um=2.0, amplitude_nm=50.0), BakeParameters())
    wi = np.array([0.0, 0.0, 1.0])
    sine = np.linspace(0.17, 0.40, 400)
    wr = np.stack([sine, 0 * sine, np.sqrt(1 - sine**2)], -1)
    f = brdf(table, wi, wr) / geometry_factor(wi, wr)[:, None]
    # order 1 carries J_1(kappa a)^2, weighted by illuminant and observer, over a lobe as wide as lambda
    wavelengths, weights = spectral_weights()
    kappa = 2 * np.pi / wavelengths * (1 + np.sqrt(1 - (wavelengths / 2e-6) ** 2))
    expected = weights * (jv(1, kappa * 50e-9) ** 2 / wavelengths)[:, None]
    lobe = 550e-9 / (2 * np.pi * np.sqrt(2) * 4e-6) * 2e-6
    expected = gaussian_filter1d(expected, lobe / (wavelengths[1] - wavelengths[0]), axis=0, mode="constant")
    for channel in range(3):
        peak = sine[f[:, channel].argmax()] * 2e-6
        assert peak == pytest.approx(wavelengths[expected[:, channel].argmax()], abs=6e-9)
    y = f[:, 1]
    # and nothing across the grooves
    across = brdf(table, wi, wr[:, [1, 0, 2]]) / geometry_factor(wi, wr)[:, None]
    assert across.max() < 1e-3 * y.max()


def test_a_facet_sends_light_where_its_normal_points():
    """h = s x tilts the mirror: half vector (-s, 0, 1). Light from above leaves towards -x."""
    pixels, step, slope = 400, 60e-9, 0.12
    x = (np.arange(pixels) + 0.5) * step
    field = HeightField(np.broadcast_to(slope * x, (pixels, pixels)), step, step)
    table = bake(field, BakeParameters(tolerance=1e-3))
    sine = np.linspace(-0.5, 0.5, 2001)
    wr = np.stack([sine, 0 * sine, np.sqrt(1 - sine**2)], -1)
    y = brdf(table, np.array([0.0, 0.0, 1.0]), wr)[..., 1]
    assert sine[y.argmax()] == pytest.approx(-np.sin(2 * np.arctan(slope)), abs=0.01)


@pytest.mark.parametrize("ensemble", ["average", "single"])
def test_flat_patch_in_a_white_furnace_reflects_everything(ensemble):
    table = bake(make_preset("flat", size_m=65e-6, pixels=700), BakeParameters(ensemble=ensemble, sigma_s_m=6.5e-6))
    theta = np.radians([0, 20, 40, 60])
    d = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], -1)
    assert table.albedo(d) == pytest.approx(1.0, abs=0.005)


def test_albedo_equals_a_plain_integral_of_the_brdf(snake_table):
    """integral f cos dwi by a midpoint rule over (u, v) = -(wi + wr), the rim smoothed by its substitution."""
    white = np.array(snake_table.info["colour"]["white_xyz"])
    for theta, phi in ((0.0, 0.0), (0.7, 1.0), (1.2, 4.0)):
        wr = np.array([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)])
        # half vectors: polar grid round the mirror direction, fine at the specular peak
        edge = np.sinh(np.linspace(0, np.arcsinh(2 / 0.02), 1401)) * 0.02
        r = 0.5 * (edge[1:] + edge[:-1])
        a = (np.arange(720) + 0.5) * (2 * np.pi / 720)
        area = 0.5 * np.diff(edge**2) * (2 * np.pi / 720)
        xy = np.stack([r[:, None] * np.cos(a), r[:, None] * np.sin(a)], -1) - wr[:2]
        rho2 = (xy**2).sum(-1)
        keep = rho2 < 1
        wi = np.concatenate([xy, np.sqrt(np.where(keep, 1 - rho2, 1.0))[..., None]], -1)[keep]
        f = brdf(snake_table, wi, wr)
        total = (f * np.broadcast_to(area[:, None], keep.shape)[keep][:, None]).sum(0) / white
        assert snake_table.albedo(wr) == pytest.approx(total.max(), rel=0.015)


def test_energy_conserving_form_is_reciprocal_and_never_larger(snake_table):
    wi, wr = directions(300, 6, 88.0)
    raw, kept = brdf(snake_table, wi, wr), brdf(snake_table, wi, wr, energy_conserving=True)
    assert (kept <= raw * (1 + 1e-12)).all()
    assert brdf(snake_table, wr, wi, energy_conserving=True) == pytest.approx(kept, rel=1e-9)
    bright = np.maximum(1.0, np.maximum(*(snake_table.conserving_albedo(each) for each in (wi, wr))))
    assert kept == pytest.approx(raw / bright[:, None], rel=1e-9)


def test_table_lookup_is_symmetric_in_light_and_view(snake_table):
    wi, wr = directions(50, 7)
    assert brdf(snake_table, wi, wr) == pytest.approx(brdf(snake_table, wr, wi), rel=1e-12)
    assert (geometry_factor(wi, wr) > 0).all()


def test_bake_is_deterministic_and_survives_a_round_trip(tmp_path, snake):
    from precompute.scan.gsf import write_gsf
    from precompute.table.table import SpectralTable

    scan = tmp_path / "snake.gsf"
    write_gsf(snake, scan)
    parameters = BakeParameters(level="plane", detail=0.5)
    first = bake_file(scan, tmp_path / "a", parameters)
    bake_file(scan, tmp_path / "b", parameters)
    for name in ("snake.exr", "snake.json"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    again = SpectralTable.load(first.path)
    assert (again.atlas == first.table.atlas).all()
    assert again.layout == first.table.layout
    wi, wr = directions(20, 8)
    assert (brdf(again, wi, wr) == brdf(first.table, wi, wr)).all()
    assert {"read", "prepare", "transforms", "spectral sum", "write", "total"} <= first.seconds.keys()
    assert json.loads((tmp_path / "a" / "snake.json").read_text())["parameters"]["sigma_s_m"] == pytest.approx(3e-6)


def test_tolerances_out_of_reach_of_single_precision_are_refused_with_the_reason():
    """Half a range of 300 nm is kappa h = 9.9: Taylor terms of 2e4 in float32 leave 1e-3, Chebyshev terms do not."""
    heights = np.random.default_rng(1).uniform(-300e-9, 300e-9, (32, 32))
    field = HeightField(heights, 60e-9, 60e-9)
    with pytest.raises(ParameterError, match="single precision"):
        bake(field, BakeParameters(series="taylor", tolerance=1e-4))
    with pytest.raises(ParameterError, match="single precision"):
        bake(field, BakeParameters(tolerance=1e-7))
    assert bake(field, BakeParameters(series="taylor", tolerance=5e-3)).info["terms"] > 10
    assert bake(field, BakeParameters(series="chebyshev", tolerance=1e-4)).info["terms"] > 5


def test_too_large_a_table_is_refused_before_the_work(snake):
    stages = []
    with pytest.raises(SizeLimitError, match="MB"):
        bake(snake, BakeParameters(limit_bytes=100_000), lambda stage, fraction: stages.append(stage))
    assert "transforms" not in stages


def test_cancelling_leaves_nothing(tmp_path, snake):
    from precompute.scan.gsf import write_gsf

    scan = tmp_path / "snake.gsf"
    write_gsf(snake, scan)

    def stop(stage, fraction):
        if fraction > 0.3:
            raise Cancelled

    with pytest.raises(Cancelled):
        bake_file(scan, tmp_path / "out", BakeParameters(detail=0.5), stop)
    assert list((tmp_path / "out").iterdir()) == []


def test_progress_rises_to_one(snake, tmp_path):
    from precompute.scan.gsf import write_gsf

    scan = tmp_path / "snake.gsf"
    write_gsf(snake, scan)
    seen = []
    bake_file(scan, tmp_path, BakeParameters(detail=0.4), lambda stage, fraction: seen.append(fraction))
    assert seen == sorted(seen)
    assert seen[-1] == 1.0


def mirror_map(table):
    """Luminance over view directions for light at 60 degrees; the mirror direction is (x, y) = (-0.866, 0)."""
    wi = np.array([np.sin(np.pi / 3), 0.0, 0.5])
    x, y = np.meshgrid(*(2 * [np.linspace(-0.97, 0.97, 389)]))
    keep = x**2 + y**2 < 0.94
    wr = np.stack([x, y, np.sqrt(np.where(keep, 1 - x**2 - y**2, 1))], -1)
    return x + wi[0], y, np.where(keep, brdf(table, wi, wr)[..., 1], 0)


def test_coarse_flat_patch_has_no_false_orders():
    """267 nm pixels put lambda / dx in view unless the heights are interpolated: one peak, in the mirror."""
    table = bake(make_preset("flat", size_m=40e-6, pixels=150), BakeParameters(detail=0.5))
    x, y, luminance = mirror_map(table)
    away = np.hypot(x, y) > 0.2
    assert luminance.max() > 100
    assert luminance[away].max() < 1e-3 * luminance.max()


@pytest.mark.slow
def test_coarse_scan_has_its_peak_in_the_mirror(scan_dir):
    """Side walls send some light elsewhere; without interpolation a false order is 12 times the mirror."""
    x, y, luminance = mirror_map(bake(read_scan(scan_dir / "chip_80um.gsf"), BakeParameters(detail=0.5)))
    row, col = np.unravel_index(luminance.argmax(), luminance.shape)
    assert (x[row, col], y[row, col]) == pytest.approx((0.0, 0.0), abs=0.03)
    assert luminance[np.hypot(x, y) > 0.2].max() < 0.3 * luminance.max()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("ensemble", "count", "median", "p95", "megabytes"),
    [("average", 300, 0.005, 0.025, 64), ("single", 60, 0.02, 0.1, 1024)],
)
def test_table_of_the_real_scan_equals_the_reference(scan_dir, ensemble, count, median, p95, megabytes):
    scan = read_scan(scan_dir / "xenopeltis_65um_818.69nm.png", size_m=(65e-6, 65e-6), height_m=818.69e-9)
    parameters = BakeParameters(level="poly2", clip_percent=99.9, ensemble=ensemble)
    table = bake(scan, parameters)
    assert table.layout.texel_bytes <= megabytes * 1e6
    # Single precision: a third of the time at an error of 1e-6.
    error = table_error(prepare(scan, parameters), parameters, table, directions(count, 9), np.complex64)
    assert np.median(error) <= median
    assert np.percentile(error, 95) <= p95
