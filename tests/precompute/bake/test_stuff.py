# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes with the surface's stuff inside: films, metals, lacquer; and the energy of single wavelengths."""

import numpy as np
import pytest

from precompute.bake import bake
from precompute.errors import ParameterError
from precompute.evaluate.direct import direct_f, direct_xyz
from precompute.evaluate.directions import from_angles
from precompute.evaluate.orders import order_efficiencies
from precompute.evaluate.scaled import ScaledTable
from precompute.evaluate.surface import brdf, cos_half, lacquer_factor, lacquer_uvw
from precompute.light.colour import spectral_weights
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan.preparation import prepare
from precompute.stack import fresnel_exact, parse_stack
from precompute.table.table import SpectralTable

FILM = parse_stack("au", ["2.35:250"])


@pytest.fixture(scope="module")
def bumps():
    return make_preset("stam_bumps", 14e-6, 144)


def directions(count, seed, degrees=65.0):
    rng = np.random.default_rng(seed)
    theta, phi = np.radians(rng.uniform(0, degrees, (2, count))), rng.uniform(0, 2 * np.pi, (2, count))
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


@pytest.mark.parametrize("stuff", [{}, {"stack": FILM}, {"stack": FILM, "lacquer": "PMMA"}])
def test_table_equals_direct_times_r(bumps, stuff):
    parameters = BakeParameters(**stuff)
    table = bake(bumps, parameters)
    wi, wr = directions(14, 2)
    given = {"stack": parameters.stack, "lacquer": parameters.lacquer}
    patch, sigma = prepare(bumps, parameters), table.info["parameters"]["sigma_s_m"]
    truth = direct_xyz(patch, sigma, "average", wi, wr, **given)
    error = np.abs(brdf(table, wi, wr)[:, 1] / truth[:, 1] - 1)
    assert np.median(error) < 0.007
    assert np.percentile(error, 95) < 0.025
    if "lacquer" in stuff:
        assert table.layout.w_max == pytest.approx(2 * 1.4906, rel=1e-3)
        assert table.index == pytest.approx(1.4906, rel=1e-3)


@pytest.mark.slow
def test_mirror_shows_the_spectral_integral_of_r():
    """The specular peak of a flat plate is R at the half angle, colour and all."""
    plate = make_preset("flat", 20e-6, 220)
    bare = bake(plate, BakeParameters())
    for name in ("Au", "Cu", "Ti"):
        table = bake(plate, BakeParameters(stack=parse_stack(name)))
        for theta in (0.2, 0.9):
            wi, wr = from_angles(theta, 0.0), from_angles(theta, np.pi)
            lam, weights = spectral_weights()
            # The peak carries 1 / lambda^2.
            peak = weights / lam[:, None] ** 2
            r = parse_stack(name).reflectance(lam, np.cos([theta]))[:, 0]
            assert brdf(table, wi, wr) / brdf(bare, wi, wr) == pytest.approx((r @ peak) / peak.sum(0), rel=2e-3)


def test_direct_f_is_t_times_the_stacks_r(bumps):
    wi, wr = from_angles(0.5, 0.3), from_angles(0.2, 2.0)
    patch = prepare(bumps, BakeParameters())
    plain, coated = (direct_f(patch, 2e-6, "average", wi, wr, 500e-9, stack=stack) for stack in (None, FILM))
    assert coated / plain == pytest.approx(FILM.reflectance([500e-9], cos_half(wi, wr)[None])[0, 0], rel=1e-12)


def test_flat_mirror_under_lacquer_reflects_t_squared():
    """The factor in front of T at the mirror direction, and the albedo of the table: both are t(theta)^2 at most."""
    n = 1.5
    for theta in (0.0, 0.6, 1.2):
        wi, wr = from_angles(theta, 0.0), from_angles(theta, np.pi)
        t = 1.0 - fresnel_exact(n, np.cos(theta))
        # A mirror's f = delta / cos: T holds the delta, and du dv = cos dwi.
        assert lacquer_factor(wi, wr, n) * np.cos(theta) == pytest.approx(t**2 * np.cos(theta) / np.sqrt(
            1 - (np.sin(theta) / n) ** 2) ** 2 * np.cos(np.arcsin(np.sin(theta) / n)) ** 2, rel=1e-9)  # fmt: skip
        u, v, w = lacquer_uvw(wi, wr, n)
        assert (u, v) == pytest.approx((0, 0), abs=1e-12)
        assert w == pytest.approx(-2 * np.sqrt(n**2 - np.sin(theta) ** 2))


def test_lacquered_plate_gives_back_its_light():
    table = bake(make_preset("flat", 20e-6, 220), BakeParameters(lacquer=1.5))
    theta = np.radians([0.0, 30.0, 60.0])
    d = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], -1)
    # The part that leaves again, with R = 1 and outer faces apart.
    assert table.albedo(d) == pytest.approx(1.0, abs=0.01)
    low, high = table.layout.w_min, table.layout.w_max
    assert low < 2 * np.sqrt(1.5**2 - 1) < high == pytest.approx(3.0)


def test_index_of_one_is_no_lacquer(bumps):
    wi, wr = directions(20, 4)
    bare, coated = (bake(bumps, BakeParameters(lacquer=each, detail=0.5)) for each in (None, 1.0))
    assert brdf(coated, wi, wr) == pytest.approx(brdf(bare, wi, wr), rel=1e-9)


@pytest.mark.slow
def test_sidecar_says_what_is_inside(bumps, tmp_path):
    stack = parse_stack("melanin", ["(chitin:100,melanin:80)x12"])
    table = bake(bumps, BakeParameters(stack=stack, lacquer="PMMA", detail=0.4))
    table.save(tmp_path / "t.exr")
    again = SpectralTable.load(tmp_path / "t.exr")
    assert again.info["stack"]["text"] == "(chitin:100,melanin:80)x12 on melanin"
    assert again.has_stack
    assert BakeParameters(stack=again.info["parameters"]["stack"]).stack == stack
    assert again.info["lacquer"]["material"] == "PMMA"
    keys = {bake(bumps, BakeParameters(stack=s, detail=0.2)).info["key"] for s in (None, stack, FILM)}
    assert len(keys) == 3
    with pytest.raises(ParameterError, match="already"):
        brdf(again, *directions(1, 1), fresnel=1.5)
    assert ScaledTable(again, scale=0.5).approximate
    assert not ScaledTable(again).approximate


def test_row_of_reflectance_is_that_of_the_stack(bumps):
    table = bake(bumps, BakeParameters(stack=FILM, detail=0.3))
    lam, weights = spectral_weights()
    cosine = np.array([1.0, 0.8, 0.3])
    expected = FILM.reflectance(lam, cosine).T @ weights
    assert table.reflectance(cosine) == pytest.approx(expected, abs=2e-3)
    bare = bake(bumps, BakeParameters(detail=0.3))
    assert (bare.reflectance(cosine) == 0).all()


def test_stuff_and_the_thesis_s_series_exclude_each_other():
    with pytest.raises(ParameterError, match="nodes"):
        BakeParameters(stack=FILM, series="taylor")
    for lacquer in (0.9, "Au", 3.5, "1.5,0.2"):
        with pytest.raises(ParameterError, match="lacquer"):
            BakeParameters(lacquer=lacquer)


def blazed(lines_per_mm, depth_nm):
    period = 1e-3 / lines_per_mm
    return period, depth_nm * 1e-9 * (np.arange(512) + 0.5) / 512


def test_littrow_sends_out_no_more_than_came_in_at_any_wavelength():
    """1200 grooves a millimetre: raw up to 1.2 of the light, conserving at most 1, order by order."""
    period, profile = blazed(1200, 250.0)
    raw, kept = [], []
    for lam in np.arange(400e-9, 701e-9, 10e-9):
        theta = np.arcsin(lam / (2 * period))
        raw.append(order_efficiencies(profile, period, lam, theta)[1].sum())
        kept.append(order_efficiencies(profile, period, lam, theta, conserving=True)[1].sum())
    assert max(raw) > 1.1
    assert max(kept) <= 1.0 + 1e-12


def test_conserving_orders_are_reciprocal():
    period, profile = blazed(1200, 250.0)
    lam, theta = 500e-9, 0.2
    m, there = order_efficiencies(profile, period, lam, theta, conserving=True)
    sine = np.sin(theta) - lam / period
    back = order_efficiencies(
        profile[::-1] if sine > 0 else profile, period, lam, abs(np.arcsin(sine)), conserving=True
    )
    # From the place of order -1, mirrored so that light comes from negative x, order -1 leads back.
    returned = dict(zip(back[0].tolist(), back[1], strict=True))
    assert min(abs(value - there[m == -1][0]) for value in returned.values()) < 1e-9


@pytest.mark.slow
def test_table_of_a_blazed_grating_conserves_each_wavelength():
    """f at single wavelengths by direct sums, divided as a renderer divides, sent out by any direction of incidence."""
    period, _ = blazed(1200, 250.0)
    grating = make_preset("blazed", (20 * period, 20 * period), 256, period_um=period * 1e6, depth_nm=250.0)
    table = bake(grating, BakeParameters())
    for lam in (450e-9, 500e-9, 560e-9, 650e-9):
        theta = float(np.arcsin(lam / (2 * period)))
        profile = 250e-9 * (np.arange(512) + 0.5) / 512
        for sign in (1.0, -1.0):
            shape = profile if sign > 0 else profile[::-1]
            m, raw = order_efficiencies(shape, period, lam, theta)
            sine = np.sin(theta) + m * lam / period
            wi = from_angles(theta, np.pi)
            wr = np.stack([sine, 0 * sine, np.sqrt(1 - sine**2)], -1)
            flip = np.array([sign, 1.0, 1.0])
            divisor = np.maximum(
                1.0, np.maximum(table.conserving_albedo(wi * flip), table.conserving_albedo(wr * flip))
            )
            assert (raw / divisor).sum() <= 1.02


def test_capped_tables_cut_each_wavelength_by_its_own_excess(bumps):
    raw, capped = (bake(bumps, BakeParameters(energy=each, detail=0.5)) for each in ("raw", "capped"))
    wi, wr = directions(60, 8, 85.0)
    assert (brdf(capped, wi, wr) <= brdf(raw, wi, wr) * 1.02).all()
    assert brdf(capped, wr, wi) == pytest.approx(brdf(capped, wi, wr), rel=1e-9)
    assert capped.albedo_max < raw.albedo_max
    assert 0.0 < raw.info["energy"]["share_cut"] < 0.5
