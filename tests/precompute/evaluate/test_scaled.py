# SPDX-License-Identifier: GPL-3.0-or-later
"""One table as that of a stretched, deepened, turned surface, against separate bakes and direct sums."""

import json

import numpy as np
import pytest

from precompute.bake import bake
from precompute.cli import main
from precompute.errors import ParameterError
from precompute.evaluate.direct import direct_xyz
from precompute.evaluate.directions import from_angles, uvw
from precompute.evaluate.scaled import ScaledTable, painted_brdf, scaled_transform
from precompute.evaluate.surface import brdf
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan.heightfield import HeightField
from precompute.stack import parse_stack
from precompute.table import scaled_albedo, scaled_bound
from precompute.table.table import SpectralTable
from tests.truth import radiance
from tests.truth.hemisphere import hemisphere

PARAMETERS = BakeParameters(sigma_s_m=3e-6, level="none")


def rough(s=1.0, q=1.0, pixels=320, side=24e-6):
    """A smooth random surface, stretched and deepened."""
    random = np.random.default_rng(7)
    waves = random.normal(0, 1.2e6, (24, 2))
    phases = random.uniform(0, 2 * np.pi, 24)
    axis = (np.arange(pixels) + 0.5) * side / pixels
    x, y = np.meshgrid(axis, axis)
    heights = sum(np.sin(kx * x + ky * y + p) for (kx, ky), p in zip(waves, phases, strict=True))
    return HeightField(q * 12e-9 * heights, s * side / pixels, s * side / pixels)


@pytest.fixture(scope="module")
def table():
    return bake(rough(), PARAMETERS)


def directions(count, seed=1):
    random = np.random.default_rng(seed)
    theta, phi = np.arccos(random.uniform(0.5, 1.0, (2, count))), random.uniform(0, 2 * np.pi, (2, count))
    return from_angles(theta[0], phi[0]), from_angles(theta[1], phi[1])


@pytest.mark.parametrize(("s", "q"), [(2 / 3, 1 / 1.3), (0.5, 0.5), (0.8, 1.0), (1.0, 0.7)])
def test_a_scaled_table_is_that_of_the_stretched_surface(table, s, q):
    """Luminance-weighted, with the coherence window stretched too."""
    other = bake(rough(s, q), BakeParameters(sigma_s_m=s * 3e-6, level="none"))
    wi, wr = directions(4000)
    mine, its = brdf(ScaledTable(table, s, q), wi, wr)[..., 1], brdf(other, wi, wr)[..., 1]
    assert np.abs(mine - its).sum() / its.sum() < 0.01


def stretched(field, s, q):
    return HeightField(q * field.heights, s * field.dx, s * field.dy)


@pytest.mark.slow
@pytest.mark.parametrize("preset", ["sinusoid", "foil", "snake", "blazed", "cd"])
@pytest.mark.parametrize(("s", "q"), [(2 / 3, 1 / 1.3), (0.5, 0.5), (0.85, 1.0), (0.95, 0.6)])
def test_twenty_pairs(preset, s, q):
    """Every structure that paint is for, luminance-weighted."""
    field = make_preset(preset, 24e-6, 384)
    one = bake(field, BakeParameters(sigma_s_m=2.4e-6, level="none"))
    other = bake(stretched(field, s, q), BakeParameters(sigma_s_m=s * 2.4e-6, level="none"))
    wi, wr = directions(20000)
    mine, its = brdf(ScaledTable(one, s, q), wi, wr)[..., 1], brdf(other, wi, wr)[..., 1]
    error = np.abs(mine - its).sum() / its.sum()
    print(f"{preset} s {s:.2f} q {q:.2f}: {100 * error:.2f} %")
    assert error < 0.01


def test_against_direct_sums(table):
    """No table of the other surface in between."""
    s, q = 0.7, 0.8
    wi, wr = directions(8, seed=3)
    mine = brdf(ScaledTable(table, s, q), wi, wr)[..., 1]
    truth = np.array([direct_xyz(rough(s, q), s * 3e-6, "average", i, r)[1] for i, r in zip(wi, wr, strict=True)])
    assert np.abs(mine - truth).sum() / truth.sum() < 0.015


def test_turned_structure_is_the_structure_seen_from_turned_directions(table):
    wi, wr = directions(200, seed=5)
    for angle in (0.4, 2.0, -1.1):
        c, s = np.cos(angle), np.sin(angle)
        back = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        turned = brdf(ScaledTable(table, rotation=angle), wi, wr)
        np.testing.assert_allclose(turned, brdf(table, wi @ back.T, wr @ back.T), rtol=1e-9, atol=1e-12)


def test_albedo_of_a_scaled_table_is_that_of_its_own_bake(table):
    """Beyond the table's own sampling error, and so the furnace stays closed."""
    s, q = 0.6, 0.8
    other = bake(rough(s, q), BakeParameters(sigma_s_m=s * 3e-6, level="none"))
    wr = from_angles(np.radians([0.0, 20.0, 40.0, 60.0]), np.radians([0.0, 50.0, 130.0, 300.0]))
    np.testing.assert_allclose(ScaledTable(table, s, q).albedo(wr), other.albedo(wr), rtol=0.02)


def test_turning_turns_the_albedo(table):
    wr = from_angles(np.radians(55.0), np.radians([10.0, 100.0, 200.0]))
    back = from_angles(np.radians(55.0), np.radians([-20.0, 70.0, 170.0]))
    turned, plain = ScaledTable(table, 0.9, 0.9, np.radians(30.0)), ScaledTable(table, 0.9, 0.9)
    np.testing.assert_allclose(turned.albedo(wr), plain.albedo(back), rtol=1e-9)


def test_paint_is_one_scaled_table_a_pixel(table):
    random = np.random.default_rng(2)
    scale, depth, mask = random.uniform(0.4, 1.0, (3, 3, 4))
    rotation = random.uniform(0, 6.0, (3, 4))
    wi, wr = from_angles(0.5, 0.3), from_angles(0.2, 4.0)
    painted = painted_brdf(table, wi, wr, scale, depth, rotation, mask)
    for place in np.ndindex(3, 4):
        one = ScaledTable(table, scale[place], depth[place], rotation[place])
        np.testing.assert_allclose(painted[place], mask[place] * brdf(one, wi, wr), rtol=1e-9)


def test_senseless_scales_count_as_a_hundredth(table):
    wi, wr = from_angles(0.3, 0.0), from_angles(0.1, 1.0)
    wanted = scaled_transform(table, *uvw(wi, wr), 0.01, 0.01)
    for bad in (0.0, -2.0, np.nan):
        np.testing.assert_array_equal(scaled_transform(table, *uvw(wi, wr), bad, bad), wanted)
    with pytest.raises(ParameterError, match="A scale of 0 makes no sense"):
        ScaledTable(table, 0.0)


def test_command_line_and_python_agree(table, tmp_path, capsys):
    path = table.save(tmp_path / "t.exr")
    words = [
        "eval",
        str(path),
        "--wi",
        "30",
        "10",
        "--wr",
        "5",
        "200",
        "--scale",
        "0.7",
        "--depth",
        "0.9",
        "--rotation",
        "25",
    ]
    assert main([*words, "--json"]) == 0
    result = json.loads(capsys.readouterr().out)
    one = ScaledTable(table, 0.7, 0.9, np.radians(25.0))
    wi, wr = from_angles(*np.radians((30.0, 10.0))), from_angles(*np.radians((5.0, 200.0)))
    np.testing.assert_allclose(result["xyz"], brdf(one, wi, wr), rtol=1e-6)
    assert "note" not in result
    assert main(["eval", str(path), "--wi", "30", "10", "--wr", "5", "200", "--scale", "1.5"]) == 0
    assert "passes the rim of the table" in capsys.readouterr().out
    assert main(["eval", str(path), "--wi", "30", "10", "--wr", "5", "200", "--scale", "-1"]) == 2
    assert "makes no sense" in capsys.readouterr().err


@pytest.mark.parametrize(("s", "q"), [(1.6, 1.0), (1.0, 1.4), (1.5, 1.3)])
def test_headroom_holds_larger_periods_and_depths(table, s, q):
    """A table with headroom is that of the larger surface, where one without ends; at 1 both are the same."""
    roomy = bake(rough(), BakeParameters(sigma_s_m=3e-6, level="none", scale_headroom=1.6, depth_headroom=1.4))
    other = bake(rough(s, q), BakeParameters(sigma_s_m=s * 3e-6, level="none"))
    random = np.random.default_rng(5)
    theta, phi = np.arccos(random.uniform(0.15, 1.0, (2, 4000))), random.uniform(0, 2 * np.pi, (2, 4000))
    wi, wr = from_angles(theta[0], phi[0]), from_angles(theta[1], phi[1])
    its = brdf(other, wi, wr)[..., 1]

    def error(which, scale=s, depth=q, wanted=its):
        return np.abs(brdf(ScaledTable(which, scale, depth), wi, wr)[..., 1] - wanted).sum() / wanted.sum()

    assert error(roomy) < 0.01
    assert error(roomy, 1.0, 1.0, brdf(table, wi, wr)[..., 1]) < 0.01
    assert not ScaledTable(roomy, s, q).beyond and ScaledTable(table, s, q).beyond
    assert roomy.layout.index == 1.0


def test_headroom_survives_the_file_and_leaves_no_trace_where_there_is_none(table, tmp_path):
    from precompute.table import SpectralTable

    roomy = bake(rough(pixels=260), BakeParameters(sigma_s_m=3e-6, level="none", detail=0.3, scale_headroom=1.3))
    assert SpectralTable.load(roomy.save(tmp_path / "r.exr")).headroom == (1.3, 1.0)
    assert roomy.info["parameters"]["scale_headroom"] == 1.3
    assert "headroom" not in table.save(tmp_path / "t.exr").with_suffix(".json").read_text(encoding="utf-8")
    for wrong in (0.5, 20.0, float("nan")):
        with pytest.raises(ParameterError, match="headroom of Scale"):
            BakeParameters(scale_headroom=wrong)


@pytest.mark.parametrize(("s", "q"), [(0.8, 1.0), (0.5, 0.6), (0.3, 0.9)])
def test_tiles_of_albedo_hold_at_least_what_conserves_energy(table, s, q):
    """Against the bake's own quadrature: hardly ever too small, and near it on average."""
    scaled = ScaledTable(table, s, q)
    random = np.random.default_rng(9)
    wr = from_angles(np.radians(random.uniform(0, 75, 400)), random.uniform(0, 2 * np.pi, 400))
    ratio = np.maximum(scaled.conserving_albedo(wr), 1.0) / np.maximum(scaled.albedo(wr), 1.0)
    assert np.quantile(ratio, 0.02) > 0.97
    assert ratio.mean() < 1.08


@pytest.mark.parametrize("name", ["sinusoid", "foil"])
def test_next_to_no_depth_is_a_mirror(name):
    """All light comes back, and none is made, where the table's slices are far apart from each other."""
    own = bake(make_preset(name, 24e-6, 256), BakeParameters(sigma_s_m=1.5e-6, level="none"))
    wr = from_angles(np.radians(20.0), 1.0)
    for depth in (0.15, 0.13, 0.12, 0.11, 0.1, 0.09, 0.07, 0.05, 0.03, 0.01):
        scaled = ScaledTable(own, 0.8, depth)
        sent = scaled.albedo(wr)
        assert sent > 0.96, depth
        assert sent / max(1.0, scaled.conserving_albedo(wr)) < 1.01, depth


@pytest.mark.parametrize(("s", "q"), [(0.8, 1.0), (0.8, 0.8), (1.0, 0.6)])
@pytest.mark.parametrize(("substrate", "films"), [("au", []), ("al", ["1.46:500"])])
def test_a_stack_of_few_films_is_corrected(substrate, films, s, q):
    """To 1 percent, where the table's own angle would be wrong by 2 to 10."""
    parameters = {"level": "none", "detail": 0.5, "stack": parse_stack(substrate, films)}
    one = bake(rough(pixels=260), BakeParameters(sigma_s_m=3e-6, **parameters))
    other = bake(rough(s, q, pixels=260), BakeParameters(sigma_s_m=s * 3e-6, **parameters))
    wi, wr = directions(4000)
    scaled = ScaledTable(one, s, q)
    mine, its = brdf(scaled, wi, wr), brdf(other, wi, wr)
    assert (np.abs(mine - its).sum(0) / its.sum(0) < 0.012).all()
    assert scaled.approximate


def cell_errors(field, parameters, pairs):
    """Light of a sky that brightens to one side that each (s, q) sends straight up and aslant, over that of a bake of
    its own, less 1; energy conserved.
    """
    wi, solid_angle = hemisphere(160)
    light = (0.3 + 10.0 * np.maximum(wi @ np.array([0.4, 0.3, 0.87]), 0.0) ** 3) * solid_angle
    one, errors = bake(field, parameters(1.0)), []
    for s, q in pairs:
        own, mine = bake(stretched(field, s, q), parameters(s)), ScaledTable(one, s, q)
        for wr in (from_angles(0.05, -1.5), from_angles(0.5, 0.7)):
            seen, truth = ((radiance.f_cos_xyz(each, wi, wr)[..., 1] * light).sum() for each in (mine, own))
            errors.append(seen / truth - 1.0)
    return np.array(errors)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("sinusoid", 3), ("foil", 3),
        *(pytest.param(name, 10, marks=pytest.mark.slow) for name in ("foil", "snake", "cd", "blazed")),
        pytest.param("sinusoid", 50, marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_a_cell_sends_out_what_a_bake_of_its_own_would(name, count):
    """Within 2 percent with energy conserved: single wavelengths of scaled surfaces are bounded as their bakes do.

    Other structures than the grating may pass it by a little where an order meets the horizon.
    """
    numbers = {"period_um": 1.4, "amplitude_nm": 60.0} if name == "sinusoid" else {}
    field = make_preset(name, 24e-6, 300, **numbers)
    sigma = 1.5e-6 if name == "sinusoid" else 2e-6
    pairs = np.random.default_rng(5).uniform(0.5, 1.0, (count, 2))
    errors = cell_errors(field, lambda s: BakeParameters(sigma_s_m=s * sigma, level="none", detail=0.6), pairs)
    print(
        f"{name}: worst of {count} cells {100 * np.abs(errors).max():.2f} %, mean {100 * np.abs(errors).mean():.2f} %"
    )
    assert np.abs(errors).max() < (0.02 if name == "sinusoid" else 0.025)


def test_a_table_without_bounds_of_scaled_surfaces_is_read(table):
    """As older releases wrote it, or damaged: what its own surface needs is taken then."""
    bound = scaled_bound.unpack(table.info)
    assert np.array_equal(scaled_bound.unpack({"energy": {"scaled_bound": scaled_bound.pack(bound)}}), bound)
    assert (bound >= 1.0).all()
    energy = {key: value for key, value in table.info["energy"].items() if key != "scaled_bound"}
    damaged = {**energy, "scaled_bound": {**table.info["energy"]["scaled_bound"], "data": "no"}}
    for info in ({}, {"energy": energy}, {"energy": damaged}):
        assert scaled_bound.unpack(info) is None
        older = SpectralTable(table.layout, table.atlas, {**table.info, "energy": info.get("energy", {})})
        tiles = scaled_albedo.scaled_albedos(older)
        assert tiles.shape == (scaled_albedo.HEIGHT, scaled_albedo.WIDTH, 3)
        assert (tiles > 0.0).all()
