# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights from files: what they weigh, what is refused, and that their values, not their names, decide a table."""

from __future__ import annotations

import json

import numpy as np
import pytest

from precompute import cli
from precompute.bake.baking import bake, bake_file
from precompute.errors import ParameterError
from precompute.light.colour import can_be_white, luminance_row, spectral_weights, white_xyz, xyz_to_rgb_matrix
from precompute.light.illuminant import Spectrum, illuminant_of, read_spectrum, to_json
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf
from precompute.sweep import make_tasks
from precompute.table.cache import TableCache, table_key
from precompute.table.table import SpectralTable
from tests.support.light_files import cie, light_file


def line_at(centre_nm, width_nm=2.0, step_nm=0.1):
    """A Gaussian line of a laser or a lamp."""
    nm = np.arange(380, 780 + step_nm / 2, step_nm)
    return Spectrum(tuple(nm * 1e-9), tuple(np.exp(-0.5 * ((nm - centre_nm) / width_nm) ** 2)))


@pytest.fixture(scope="module")
def scan():
    return make_preset("sinusoid", 10e-6, 120)


@pytest.fixture(scope="module")
def quick():
    return {"detail": 0.2, "sigma_s_m": 0.8e-6}


def test_the_values_of_d65_give_the_table_of_d65(tmp_path, scan, quick):
    """To the last bit; also the matrices and the white are the same."""
    light = read_spectrum(light_file(tmp_path / "day.csv", *cie()))
    named, measured = (bake(scan, BakeParameters(illuminant=each, **quick)) for each in ("D65", light))
    assert np.array_equal(named.atlas, measured.atlas)
    assert named.layout == measured.layout
    assert np.array_equal(xyz_to_rgb_matrix("ACEScg", light), xyz_to_rgb_matrix("ACEScg", "D65"))
    assert np.array_equal(white_xyz(light), white_xyz("D65"))


def test_scale_of_the_values_does_not_matter(tmp_path):
    nm, power = cie("FL11")
    light = read_spectrum(light_file(tmp_path / "lamp.txt", nm, 17.0 * power, "\t"))
    assert np.allclose(spectral_weights(illuminant=light)[1], spectral_weights(illuminant="FL11")[1], rtol=1e-12)


def test_interpolates_as_colour_science_does_by_lines(tmp_path):
    """Uneven samples: `SpectralDistribution` with its linear interpolator is the reference."""
    import colour

    nm = np.sort(np.concatenate([[375.0, 380.0, 780.0, 790.0], np.random.default_rng(1).uniform(381, 779, 40)]))
    nm = nm[np.concatenate([[True], np.diff(nm) > 1.5])]
    power = np.random.default_rng(2).uniform(0, 3, len(nm))
    lam, weights = spectral_weights(illuminant=Spectrum(tuple(nm * 1e-9), tuple(power)))
    found = colour.SpectralDistribution(dict(zip(nm, power, strict=True)), interpolator=colour.LinearInterpolator)
    cmfs = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    xyz = found[lam * 1e9][:, None] * cmfs[lam * 1e9]
    xyz[[0, -1]] /= 2
    assert np.allclose(weights, xyz / xyz[:, 1].sum(), atol=1e-9)


@pytest.mark.parametrize("centre", [450.0, 532.37, 589.3])
@pytest.mark.parametrize("width", [0.05, 2.0])
@pytest.mark.parametrize("step", [1e-9, 5e-9])
def test_a_line_keeps_its_chromaticity_wherever_it_falls(centre, width, step):
    """A line of 0.05 nm between two wavelengths of the quadrature must not be lost."""
    weights = spectral_weights(illuminant=line_at(centre, width, 0.025), step_m=step)[1].sum(axis=0)
    lam, observer = spectral_weights(illuminant="E")
    expected = np.array([np.interp(centre * 1e-9, lam, observer[:, c]) for c in range(3)])
    assert np.allclose(weights / weights.sum(), expected / expected.sum(), atol=0.002 if step < 2e-9 else 0.02)


def test_under_a_line_a_grating_sends_its_orders_where_the_grating_equation_says(scan):
    """2 nm at 532 nm: T over u peaks at lambda / d and 2 lambda / d, and all its colours are that of the light."""
    light = line_at(532.0)
    table = bake(make_preset("sinusoid", 24e-6, 256, period_um=2.0, amplitude_nm=60.0), BakeParameters(
        illuminant=light, sigma_s_m=2.4e-6, detail=0.5
    ))  # fmt: skip
    u = np.linspace(0.1, 0.75, 2601)
    found = table.transform(u, np.zeros_like(u), np.full_like(u, -1.9))
    for order in (1, 2):
        near = np.abs(u - order * 0.266) < 0.08
        middle = (u[near] * found[near, 1]).sum() / found[near, 1].sum()
        assert middle == pytest.approx(order * 0.532 / 2.0, abs=0.004)
    bright = found[:, 1] > 0.01 * found[:, 1].max()
    assert np.allclose(found[bright] / found[bright, 1:2], white_xyz(light), rtol=0.02, atol=0.003)


def test_light_that_no_eye_adapts_to_keeps_its_colour():
    """A laser's white has a cone response of next to nothing: dividing by it would turn rounding into colours."""
    for centre in (450.0, 589.0, 640.0):
        light = line_at(centre)
        assert not can_be_white(light)
        assert np.array_equal(xyz_to_rgb_matrix("ACEScg", light), xyz_to_rgb_matrix("ACEScg", light_like_d65()))
        assert luminance_row(illuminant=light) @ (xyz_to_rgb_matrix(illuminant=light) @ white_xyz(light)) == (
            pytest.approx(1.0)
        )
    assert all(can_be_white(name) for name in ("A", "FL11", "D50", "E"))


def light_like_d65():
    """Another laser: without adaptation the matrix depends on no light."""
    return line_at(600.0)


def test_red_light_without_any_z_has_a_finite_albedo(scan, quick):
    red, day = (bake(scan, BakeParameters(illuminant=light, **quick)) for light in (line_at(690.0), "D65"))
    assert white_xyz(line_at(690.0))[2] < 1e-4
    theta = np.radians([0.0, 40.0, 60.0, 80.0])
    views = np.stack([np.sin(theta), np.zeros(4), np.cos(theta)], -1)
    assert red.albedo(views) == pytest.approx(day.albedo(views), rel=0.1)
    # Towards the horizon the model has no bound: a longer wave, whose lobe is wider, comes to more.
    assert day.albedo_max < red.albedo_max < 2.0 * day.albedo_max


def test_key_follows_the_values_and_not_the_name(tmp_path, scan):
    nm, power = cie()
    first = read_spectrum(light_file(tmp_path / "a.csv", nm, power))
    same = read_spectrum(light_file(tmp_path / "b.csv", nm, power))
    power = power.copy()
    power[40] *= 1.001
    changed = read_spectrum(light_file(tmp_path / "a.csv", nm, power))
    keys = [table_key(scan, BakeParameters(illuminant=each)) for each in (first, same, changed, "D65")]
    assert keys[0] == keys[1]
    assert len(set(keys)) == 3


def test_table_and_cache_carry_the_spectrum(tmp_path, scan, quick):
    write_gsf(scan, tmp_path / "scan.gsf")
    light = read_spectrum(light_file(tmp_path / "lamp.csv", *cie("FL11")))
    cache = TableCache(tmp_path / "cache")
    chosen = BakeParameters(illuminant=light, **quick)
    assert bake_file(tmp_path / "scan.gsf", tmp_path / "out", chosen, cache=cache).cache == "stored"
    table = SpectralTable.load(tmp_path / "out" / "scan.exr")
    found = illuminant_of(table.info["colour"]["illuminant"])
    assert found == light
    assert found.name == "lamp.csv"
    assert table.light == table.info["colour"]["adapted"] == "D65"
    assert white_xyz("D65") == pytest.approx(table.info["colour"]["white_xyz"])
    # Baked again from nothing but the sidecar: the same key, so the cache has it; the name may be another one.
    again = BakeParameters(illuminant=illuminant_of({**to_json(found), "name": "other.csv"}), **quick)
    report = bake_file(tmp_path / "scan.gsf", tmp_path / "again", again, cache=cache)
    assert report.cache == "hit"
    assert report.table.info["colour"]["illuminant"]["name"] == "other.csv"
    assert np.array_equal(report.table.atlas, table.atlas)


def test_sweep_names_its_tables_by_the_file(tmp_path):
    lights = ["A", read_spectrum(light_file(tmp_path / "lamp_3.csv", *cie()))]
    names = [task.name for task in make_tasks(["scan.gsf"], BakeParameters(), {"illuminant": lights})]
    assert names == ["scan_A", "scan_lamp_3"]


def test_command_line(tmp_path, scan, capsys):
    write_gsf(scan, tmp_path / "scan.gsf")
    lamp = light_file(tmp_path / "lamp.csv", *cie("A"))
    rest = ["--sigma-s-um", "0.8", "--detail", "0.2"]
    out = ["bake", str(tmp_path / "scan.gsf"), "--out", str(tmp_path / "out")]
    assert cli.main([*out, "--illuminant", str(lamp), "--name", "file", *rest]) == 0
    assert cli.main([*out, "--illuminant", "A", "--name", "name", *rest]) == 0
    tables = [SpectralTable.load(tmp_path / "out" / f"{name}.exr") for name in ("file", "name")]
    assert np.array_equal(tables[0].atlas, tables[1].atlas)
    sweep = ["sweep", str(tmp_path / "scan.gsf"), "--out", str(tmp_path / "many"), "--workers", "0", *rest]
    assert cli.main([*sweep, "--illuminant", "E", str(lamp), "--json"]) == 0
    report = json.loads((tmp_path / "many" / "sweep.json").read_text())
    assert [entry["name"] for entry in report] == ["scan_E", "scan_lamp"]
    capsys.readouterr()
    lamp.write_text("400,1\n500,2\n")
    assert cli.main([*out, "--illuminant", str(lamp), *rest]) == 2
    assert "covers 400-500 nm" in capsys.readouterr().err
    assert cli.main([*out, "--illuminant", "D66", *rest]) == 2
    assert "choose one of D65" in capsys.readouterr().err


NM = np.arange(380, 781, 5)


@pytest.mark.parametrize(
    "text",
    [
        "\n".join(f"{a},{b}" for a, b in zip(NM, NM, strict=True)),
        "Lamp 3\nnm; power [a.u.]\n" + "\n".join(f"{a},0; {b},0" for a, b in zip(NM, NM, strict=True)),
        "# made by hand\n\n" + "\n".join(f"  {a}\t{b}e0 " for a, b in zip(NM, NM, strict=True)),
        "\ufeffnm,W\r\n" + "\r\n".join(f"{a}, {b}," for a, b in zip(NM, NM, strict=True)),
    ],
    ids=["commas", "decimal commas", "tabs", "trailing commas"],
)  # fmt: skip
def test_ways_to_write_a_light(tmp_path, text):
    path = tmp_path / "light.csv"
    path.write_bytes(text.encode())
    found = read_spectrum(path)
    assert np.allclose(found.wavelengths_m, NM * 1e-9, rtol=1e-12)
    assert np.allclose(found.power, NM)


def rows(**changes):
    power = dict(zip(NM.tolist(), NM.tolist(), strict=True))
    power.update({int(key[1:]): value for key, value in changes.items()})
    return "\n".join(f"{a},{b}" for a, b in power.items() if b is not None)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("\n".join(reversed(rows().splitlines())), "sort its lines"),
        (rows() + "\n780,3", "sort its lines"),
        (rows(_380=None), "covers 385-780 nm"),
        ("0.38,1\n0.5,1\n0.6,1\n0.7,1\n0.78,1", "covers 0.38-0.78 nm"),
        (rows(_500=-0.1), "negative at 500 nm"),
        (rows(_500="nan"), "no finite number"),
        (rows(_500="inf"), "no finite number"),
        (rows(_500="oops"), "line 25"),
        ("380,1\n500,1\n780,1", "at least 5"),
        ("nothing\nhere", "no numbers"),
        ("", "no numbers"),
        ("\n".join(f"{a},{a},{a}" for a in NM), "line 1"),
        ("\n".join(f"{a},0" for a in NM), "dark"),
        ("a\0b", "no text"),
    ],
)
def test_what_is_no_light_is_refused_with_the_reason(tmp_path, text, words):
    path = tmp_path / "light.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ParameterError, match=words) as found:
        read_spectrum(path)
    assert "light.csv" in str(found.value)


def test_missing_huge_and_damaged(tmp_path):
    with pytest.raises(ParameterError, match="cannot be read"):
        read_spectrum(tmp_path / "none.csv")
    (tmp_path / "huge.csv").write_bytes(b"1" * (5 << 20))
    with pytest.raises(ParameterError, match="larger than 4 MB"):
        read_spectrum(tmp_path / "huge.csv")
    for damaged in (
        {"power": [1]},
        '{"wavelengths_m": 3}',
        "{",
        None,
        7,
        {"wavelengths_m": ["a"], "power": [1]},
        {"wavelengths_m": [10**400], "power": [1]},
        ["D65"],
    ):
        with pytest.raises(ParameterError):
            illuminant_of(damaged)
    with pytest.raises(ParameterError, match="one value each"):
        Spectrum((1e-7, 9e-7), (1.0,))
