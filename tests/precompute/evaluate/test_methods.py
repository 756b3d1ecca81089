# SPDX-License-Identifier: GPL-3.0-or-later
"""The thesis's methods against direct sums, closed forms and each other."""

from __future__ import annotations

import numpy as np
import pytest

from precompute.bake.series import taylor_bound
from precompute.errors import ParameterError
from precompute.evaluate.direct import DirectEvaluator
from precompute.evaluate.methods import METHODS, make_method
from precompute.evaluate.methods.bins import KAPPA_MAX
from precompute.evaluate.methods.periodic import Periodic, periodic_sinc, replica_factor
from precompute.evaluate.methods.windowed import Windowed
from precompute.scan.heightfield import HeightField
from tests.truth import plain_sums

POINTS = [(0.0, 0.0, -2.0, 550e-9), (0.31, -0.22, -1.7, 400e-9), (-1.2, 0.7, -0.6, 700e-9), (0.9, 0.0, -1.2, 380e-9)]


def rough(rows=24, cols=30, step=90e-9, rms=50e-9, seed=1):
    rng = np.random.default_rng(seed)
    return HeightField(rng.normal(0.0, rms, (rows, cols)), step, 1.1 * step)


@pytest.mark.parametrize("series", ["chebyshev", "taylor"])
@pytest.mark.parametrize("sigma", [200e-9, 2e-6])
def test_untruncated_window_is_the_window_integral(series, sigma):
    field = rough()
    method = make_method("windowed", field, sigma, series=series, tolerance=1e-7)
    for u, v, w, wavelength in POINTS:
        expected = plain_sums.single(field.heights, field.dx, field.dy, sigma, u, v, w, wavelength)
        assert method.transform(u, v, w, wavelength) == pytest.approx(expected, rel=1e-4, abs=1e-6)


def test_points_on_a_line_and_scattered_points_agree():
    """Points that share fy take a shorter way."""
    field = rough()
    u, w = np.linspace(-1, 1, 7), np.linspace(-2, -1, 7)
    for name, options in (("windowed", {}), ("pq", {"replicas": (3, 2)})):
        method = make_method(name, field, 300e-9, **options)
        line = method.transform(u, 0.2, w, 500e-9)
        alone = [float(method.transform(a, 0.2, b, 500e-9)) for a, b in zip(u, w, strict=True)]
        assert np.allclose(line, alone, rtol=1e-10)


def test_truncated_neighbourhood_is_the_sum_over_nine_bins():
    """Written down: the patch's DFT on its own bins times the window's transform at the nine nearest."""
    field, sigma, wavelength = rough(), 400e-9, 500e-9
    u, v, w = 0.23, -0.31, -1.6
    rows, cols = field.shape
    x = (np.arange(cols) - (cols - 1) / 2) * field.dx
    y = (np.arange(rows) - (rows - 1) / 2) * field.dy
    p = np.exp(2j * np.pi / wavelength * w * field.heights)
    step_x, step_y = 1 / (cols * field.dx), 1 / (rows * field.dy)
    fx, fy = u / wavelength, v / wavelength
    P = 0
    for r in np.rint(fy / step_y) + np.array([-1, 0, 1]):
        for s in np.rint(fx / step_x) + np.array([-1, 0, 1]):
            F = (
                (p * np.exp(2j * np.pi * (s * step_x * x[None, :] + r * step_y * y[:, None]))).sum()
                * field.dx
                * field.dy
            )
            away = (fx - s * step_x) ** 2 + (fy - r * step_y) ** 2
            P += F * 2 * np.pi * sigma**2 * np.exp(-2 * (np.pi * sigma) ** 2 * away) * step_x * step_y
    g = np.exp(-(x[None, :] ** 2 + y[:, None] ** 2) / (2 * sigma**2))
    expected = abs(P) ** 2 / ((g**2).sum() * field.dx * field.dy * wavelength**2)
    method = make_method("windowed3x3", field, sigma, tolerance=1e-8)
    assert method.transform(u, v, w, wavelength) == pytest.approx(expected, rel=1e-5)
    shader = make_method("flss", field, sigma)
    assert shader.transform(u, v, w, wavelength) == pytest.approx(expected, rel=3e-2)
    assert method.facts["neighbours"] == shader.facts["neighbours"] == 9


@pytest.mark.parametrize("replicas", [(1, 1), (4, 3)])
def test_periodic_surface_is_the_tiled_one(replicas):
    """Brute force: the tiles laid side by side and summed pixel by pixel."""
    tile = rough(rows=9, cols=12)
    tiled = np.tile(tile.heights, (replicas[1], replicas[0]))
    method = make_method("pq", tile, replicas=replicas)
    x = (np.arange(tiled.shape[1]) + 0.5) * tile.dx
    y = (np.arange(tiled.shape[0]) + 0.5) * tile.dy
    for u, v, w, wavelength in POINTS:
        k = 2 * np.pi / wavelength
        P = np.exp(1j * k * (w * tiled + u * x[None, :] + v * y[:, None])).sum() * tile.dx * tile.dy
        expected = abs(P) ** 2 / (tiled.size * tile.dx * tile.dy * wavelength**2)
        assert method.transform(u, v, w, wavelength) == pytest.approx(expected, rel=1e-4, abs=1e-9)


@pytest.mark.parametrize("count", [1, 2, 7, 26, 101])
def test_replicas_add_up_in_phase_at_the_peaks(count):
    """The thesis's limit (N + 1)^2 with N + 1 = count, on and beside a = 2 pi m, never NaN."""
    peaks = 2 * np.pi * np.arange(-3, 4)
    assert np.allclose(replica_factor(peaks, count), count**2)
    phase = np.random.default_rng(2).uniform(-20, 20, 300)
    phase = np.concatenate([phase, peaks + 1e-9, peaks + 1e-5])
    direct = np.abs(np.exp(1j * np.outer(np.arange(count), phase)).sum(axis=0)) ** 2
    assert np.allclose(replica_factor(phase, count), direct, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("count", [5, 8])
def test_periodic_sinc_interpolates_a_dft(count):
    """A trigonometric polynomial is given back between its samples, for even and odd counts."""
    rng = np.random.default_rng(3)
    values = rng.normal(size=count)
    m = np.arange(count) - (count - 1) / 2
    bins = np.fft.fftfreq(count)
    samples = np.exp(2j * np.pi * np.outer(bins, m)) @ values
    f = rng.uniform(-2, 2, 20)
    between = periodic_sinc(f[:, None] - bins, count) @ samples
    assert np.allclose(between, np.exp(2j * np.pi * np.outer(f, m)) @ values)


def test_flat_patch_reaches_the_area_of_each_method():
    field = HeightField(np.zeros((20, 20)), 90e-9, 90e-9)
    for name in METHODS:
        if name in ("flss", "windowed3x3"):
            continue  # nine bins of a patch much wider than the window are not the whole integral
        method = make_method(name, field, 200e-9, replicas=(5, 4))
        assert method.transform(0.0, 0.0, -2.0, 500e-9) * 500e-9**2 == pytest.approx(method.area_m2, rel=1e-6)


def test_blaze_has_the_envelope_of_its_facet():
    """Order m of a blazed grating carries sinc^2(m - m0), m0 where the facet's mirror direction lies."""
    period, depth, wavelength, count = 2.5e-6, 250e-9, 500e-9, 250
    x = (np.arange(count) + 0.5) * period / count
    field = HeightField(np.tile(depth * x / period, (2, 1)), period / count, period / count)
    method = Periodic(field, (10, 1))
    orders = np.arange(-3, 4)
    # Light from the normal: order m leaves at sin(theta_r) = -u = m lambda / d.
    w = -(1 + np.sqrt(1 - (orders * wavelength / period) ** 2))
    power = method.transform(-orders * wavelength / period, np.zeros(7), w, wavelength)
    # Phase across a period: k w depth from the height, -2 pi m from the direction.
    expected = np.sinc(w * depth / wavelength - orders) ** 2
    assert np.allclose(power / method.area_m2 * wavelength**2, expected, atol=0.01 * expected.max())
    # A facet that rises to the right throws the light to the left: slope 0.1, so near sin(theta_r) = -0.2, order -1.
    assert orders[power.argmax()] == -1


def test_taylor_bound_is_shown_and_holds():
    field = rough()
    method = Windowed(field, 300e-9, "taylor", 1e-4)
    x = KAPPA_MAX * np.ptp(field.heights) / 2
    assert method.facts["x"] == pytest.approx(x)
    assert method.facts["bound"] == taylor_bound(x, method.facts["terms"] - 1) <= 1e-4


def test_tolerance_beyond_single_precision_is_refused_with_the_numbers():
    """Terms grow to e^x; at x = 13.5 a rounding of 2^-24 leaves 4 %."""
    heights = rough().heights
    field = HeightField(heights * (0.818e-6 / np.ptp(heights)), 90e-9, 90e-9)
    with pytest.raises(ParameterError, match="Single precision"):
        make_method("flss", field, 1e-6, tolerance=1e-3)
    with pytest.raises(ParameterError, match="double precision"):
        make_method("windowed", field, 1e-6, series="taylor", tolerance=1e-14)


def test_all_methods_agree_with_the_reference_where_they_should():
    field, sigma = rough(rows=40, cols=40), 350e-9
    reference = DirectEvaluator(field, sigma, "single")
    for name in ("direct", "windowed"):
        method = make_method(name, field, sigma)
        for point in POINTS:
            assert method.transform(*point) == pytest.approx(reference.transform(*point), rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("call", [
    lambda f: make_method("fourier", f), lambda f: make_method("windowed", f, 0.0),
    lambda f: make_method("windowed", f, 1e-6, series="nodes"), lambda f: make_method("pq", f, replicas=(0, 3)),
])  # fmt: skip
def test_bad_input_is_refused(call):
    with pytest.raises(ParameterError):
        call(rough())


@pytest.mark.parametrize("replicas", [(3, 2), (1, 1)])
def test_a_bake_of_copies_is_the_periodic_method(replicas):
    """Ensemble `periodic`: prepared, tiled and evaluated by the reference, it is the method `pq`."""
    from precompute.parameters import BakeParameters
    from precompute.scan.preparation import prepare

    tile = rough(rows=9, cols=12, step=80e-9)
    patch = prepare(tile, BakeParameters(ensemble="periodic", replicas=replicas))
    assert patch.shape == (9 * replicas[1], 12 * replicas[0])
    evaluator = DirectEvaluator(patch, 1e-6, "periodic")
    method = make_method("pq", prepare(tile, BakeParameters()), replicas=replicas)
    for point in POINTS:
        assert evaluator.transform(*point) == pytest.approx(method.transform(*point), rel=1e-4, abs=1e-9)


def test_table_of_copies_follows_the_periodic_method():
    """The material: a table of 12 x 6 copies against the method, over random directions."""
    from precompute.bake.baking import bake
    from precompute.evaluate.directions import from_angles
    from precompute.evaluate.methods.flss import method_xyz
    from precompute.evaluate.surface import brdf
    from precompute.parameters import BakeParameters

    tile = rough(rows=20, cols=12, step=80e-9, rms=30e-9, seed=4)
    table = bake(tile, BakeParameters(ensemble="periodic", replicas=(12, 6)))
    rng = np.random.default_rng(5)
    wi = from_angles(rng.uniform(0, 1.2, 60), rng.uniform(0, 6.28, 60))
    wr = from_angles(rng.uniform(0, 1.2, 60), rng.uniform(0, 6.28, 60))
    expected = method_xyz(make_method("pq", tile, replicas=(12, 6)), wi, wr, step_m=2e-9)[:, 1]
    error = np.abs(brdf(table, wi, wr)[:, 1] / expected - 1)
    # 2 %; the 95th percentile is 12 %, in the nulls between the orders.
    assert np.median(error) < 0.04
    assert table.info["parameters"]["replicas"] == (12, 6)


def test_window_table_and_reference_look_alike_on_the_snake():
    """Delta E 2000 below 1 cannot be seen; 16 um of skin, one window of 2 um, random directions."""
    from precompute.bake.baking import bake
    from precompute.evaluate.colour_difference import delta_e_2000
    from precompute.evaluate.direct import direct_xyz
    from precompute.evaluate.directions import from_angles
    from precompute.evaluate.methods.flss import method_xyz
    from precompute.evaluate.surface import brdf
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    field, sigma = make_preset("snake", 16e-6), 2e-6
    rng = np.random.default_rng(5)
    wi = from_angles(rng.uniform(0, 1.2, 20), rng.uniform(0, 6.28, 20))
    wr = from_angles(rng.uniform(0, 1.2, 20), rng.uniform(0, 6.28, 20))
    table = brdf(bake(field, BakeParameters(ensemble="single", sigma_s_m=sigma)), wi, wr)
    window = method_xyz(make_method("windowed", field, sigma), wi, wr)
    reference = direct_xyz(field, sigma, "single", wi, wr, step_m=5e-9)
    # Exposed so that none of the directions is shown brighter than white: differences cannot hide there.
    exposure = 1.0 / reference[:, 1].max()
    for one, other in ((window, reference), (table, reference), (table, window)):
        assert np.median(delta_e_2000(one, other)) < 1
        assert np.median(delta_e_2000(one, other, exposure)) < 1


def test_command_line_takes_a_method(tmp_path, capsys):
    """`direct --method` gives the reference's number by another way, and says what it took."""
    import json

    from precompute.cli import main

    path = str(tmp_path / "grating.gsf")
    main(["preset", "sinusoid", "--out", path, "--size-um", "8", "--pixels", "100"])
    angles = ("--wi", "20", "10", "--wr", "-30", "5", "--json")
    values = {}
    for method in ("direct", "windowed"):
        capsys.readouterr()
        assert main(["direct", path, *angles, "--ensemble", "single", "--sigma-s-um", "1", "--method", method]) == 0
        values[method] = json.loads(capsys.readouterr().out)
    assert values["windowed"]["xyz"] == pytest.approx(values["direct"]["xyz"], rel=2e-3)
    assert values["windowed"]["terms"] > 3
    assert main(["direct", path, *angles, "--method", "flss"]) == 2
    assert "--ensemble single" in capsys.readouterr().err
    assert main(["direct", path, *angles, "--method", "pq", "--replicas", "2", "3", "--wavelength-nm", "500"]) == 0
    capsys.readouterr()
    assert main(["direct", path, *angles, "--method", "pq", "--wavelength-nm", "-3"]) == 2
    assert capsys.readouterr().err.strip().endswith(".")


def test_command_line_shows_the_chosen_order_and_its_bound(tmp_path, capsys):
    from precompute.cli import main

    path = str(tmp_path / "grating.gsf")
    main(["preset", "sinusoid", "--out", path, "--size-um", "8", "--pixels", "100"])
    options = ("--ensemble", "single", "--method", "windowed", "--series", "taylor", "--wavelength-nm", "500")
    capsys.readouterr()
    assert main(["direct", path, "--wi", "0", "0", "--wr", "10", "0", *options]) == 0
    shown = capsys.readouterr().out
    # x = 4 pi / 380 nm times the 50 nm of the preset's amplitude, met within a pixel.
    assert "x = 1.65" in shown
    assert "error at most" in shown
