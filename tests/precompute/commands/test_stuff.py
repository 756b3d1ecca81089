# SPDX-License-Identifier: GPL-3.0-or-later
"""What the surface is made of, in every command: the value is the bare one times R, and the output says so."""

import json

import numpy as np
import pytest

from precompute import cli
from precompute.presets import make_preset
from precompute.scan import write_gsf
from precompute.stack import parse_stack
from precompute.table import SpectralTable

STUFF = ["--substrate", "au", "--film", "1.46:250"]
STACK = parse_stack("au", ["1.46:250"])
DIRECTIONS = ["--wi", "40", "0", "--wr", "25", "200"]


def half(theta_i, theta_r, dphi):
    a, b = np.radians([theta_i, theta_r])
    dot = np.sin(a) * np.sin(b) * np.cos(np.radians(dphi)) + np.cos(a) * np.cos(b)
    return np.sqrt(0.5 * (1.0 + dot))


@pytest.fixture
def scan(tmp_path):
    return str(write_gsf(make_preset("stam_bumps", 8e-6, 96), tmp_path / "bumps.gsf"))


@pytest.fixture
def run(capsys):
    def call(*args):
        code = cli.main([*args, "--json"])
        out, err = capsys.readouterr()
        assert code == 0, err
        return json.loads(out)

    return call


@pytest.mark.parametrize(
    "method", [[], ["--method", "windowed", "--ensemble", "single"], ["--method", "pq", "--series", "taylor"]]
)
def test_direct_and_methods_at_one_wavelength(run, scan, method):
    given = ["direct", scan, *DIRECTIONS, "--wavelength-nm", "510", "--sigma-s-um", "1", *method]
    if "pq" in method:
        given += ["--replicas", "2", "2"]
    bare, coated = run(*given), run(*given, *STUFF)
    r = STACK.reflectance([510e-9], np.array([half(40, 25, 200)]))[0, 0]
    assert coated["f"] == pytest.approx(bare["f"] * r, rel=1e-9)
    assert coated["stack"] == "1.46:250 on Au"
    assert "stack" not in bare


def test_methods_in_colour(run, scan):
    """The sum over wavelengths of what one wavelength gives; gold is red."""
    given = ["direct", scan, *DIRECTIONS, "--sigma-s-um", "1", "--method", "windowed", "--ensemble", "single"]
    bare, gold = run(*given), run(*given, "--substrate", "Au")
    x, y, z = np.array(gold["xyz"]) / bare["xyz"]
    assert x > y > z > 0.2
    assert gold["stack"] == "Au"


def test_reflectance(run, scan):
    given = ["reflectance", scan, "--theta-i", "10", "--from", "5", "--to", "40", "--step", "1", "--sigma-s-um", "1"]
    bare, coated = run(*given), run(*given, *STUFF)
    assert coated["stack"] == "1.46:250 on Au"
    assert "stack" not in bare
    assert coated["curve"][0].keys() == bare["curve"][0].keys()


def test_response_is_the_bare_one_times_r():
    from precompute.evaluate.reflectance import Plane, response

    field = make_preset("stam_bumps", 6e-6, 72)
    plane = Plane(np.radians(10.0), np.radians([5.0, 20.0, 40.0]), np.array([450e-9, 600e-9]))
    bare, coated = (response(field, plane, sigma_s_m=1e-6, stack=stack)[0] for stack in (None, STACK))
    r = STACK.reflectance(plane.wavelengths_m, np.array([half(10, theta, 0) for theta in (5, 20, 40)]))
    assert coated == pytest.approx(bare * r, rel=1e-9)


def test_sweep_bakes_it_into_every_table(run, scan, tmp_path):
    out = run(
        "sweep", scan, "--out", str(tmp_path / "out"), "--workers", "0", "--detail", "0.2", "0.3", *STUFF,
        "--lacquer", "PMMA",
    )  # fmt: skip
    assert out["stack"] == "1.46:250 on Au"
    assert out["lacquer"]["material"] == "PMMA"
    tables = [SpectralTable.load(path) for path in out["tables"]]
    assert len(tables) == 2
    assert all(table.info["stack"]["text"] == "1.46:250 on Au" and table.index > 1.4 for table in tables)


def test_eval_and_map_of_a_table_say_it(run, scan, tmp_path):
    run("bake", scan, "--out", str(tmp_path), "--detail", "0.3", *STUFF)
    table = str(tmp_path / "bumps.exr")
    assert run("eval", table, *DIRECTIONS)["stack"] == "1.46:250 on Au"
    found = run("map", table, "--theta-i", "20", "--phi-i", "0", "--size", "16", "--out", str(tmp_path / "m.png"))
    assert found["stack"] == "1.46:250 on Au"


@pytest.mark.parametrize(
    ("command", "more"),
    [
        ("direct", DIRECTIONS),
        ("reflectance", ["--theta-i", "10", "--from", "5", "--to", "40"]),
        ("sweep", ["--out", "x"]),
    ],
)
@pytest.mark.parametrize(
    ("stuff", "says"),
    [(["--film", "SiO2:100"], "substrate"), (["--substrate", "unobtainium"], "no material"),
     (["--substrate", "au", "--film", "1.5:-3"], "-3 nm")],
)  # fmt: skip
def test_what_is_no_stack_is_one_sentence(capsys, scan, command, more, stuff, says):
    assert cli.main([command, scan, *more, *stuff]) == 2
    err = capsys.readouterr().err
    assert says in err
    assert err.count("\n") == 1
