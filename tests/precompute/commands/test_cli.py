# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line as a script sees it: JSON on stdout, one sentence and exit code 2 for bad input."""

import json
import subprocess
import sys

import numpy as np
import pytest

from precompute.bake.baking import bake_file
from precompute.cli import main
from precompute.parameters import BakeParameters
from precompute.readers import read_scan
from precompute.table.table import SpectralTable


@pytest.fixture
def run(capsys):
    """Run the command line; gives exit code, parsed JSON (or None) and stderr."""

    def call(*arguments):
        capsys.readouterr()
        code = main([str(argument) for argument in arguments])
        out, err = capsys.readouterr()
        return code, json.loads(out) if out.startswith("{") else None, err

    return call


@pytest.fixture(scope="module")
def grating(tmp_path_factory):
    path = tmp_path_factory.mktemp("cli") / "grating.gsf"
    assert main(["preset", "sinusoid", "--out", str(path), "--size-um", "16", "--pixels", "200", "--period-um", "2",
                 "--amplitude-nm", "50"]) == 0  # fmt: skip
    return path


@pytest.fixture(scope="module")
def table(grating, tmp_path_factory):
    out = tmp_path_factory.mktemp("cli_table")
    assert main(["bake", str(grating), "--out", str(out)]) == 0
    return out / "grating.exr"


def test_info_tells_what_the_preset_is(run, grating):
    code, data, _ = run("info", grating, "--json")
    assert code == 0
    assert data["shape"] == [200, 200]
    assert data["size_m"] == pytest.approx([16e-6, 16e-6])
    assert data["z_max_m"] == pytest.approx(50e-9, rel=5e-3)
    assert data["z_min_m"] == pytest.approx(-50e-9, rel=5e-3)
    assert data["rms_m"] == pytest.approx(50e-9 / np.sqrt(2), rel=1e-3)
    assert data["missing"] == 0 and data["format"] == "gsf" and data["channel"]


def test_bake_reports_and_defaults_are_as_documented(run, grating, tmp_path):
    code, data, err = run("bake", grating, "--out", tmp_path / "t", "--json")
    assert code == 0
    assert data["table"] == str(tmp_path / "t" / "grating.exr")
    loaded = SpectralTable.load(data["table"])
    parameters = loaded.info["parameters"]
    assert (parameters["level"], parameters["clip_percent"], parameters["series"]) == ("none", None, "nodes")
    assert parameters["ensemble"] == "average"
    assert parameters["sigma_s_m"] == pytest.approx(1.6e-6)
    assert data["terms"] == loaded.info["terms"]
    assert data["bytes"] == loaded.layout.texel_bytes
    assert data["seconds"]["total"] > 0 and len(data["seconds"]) > 3
    assert data["peak_rss_bytes"] is None or data["peak_rss_bytes"] > 1e7
    assert "%" in err  # progress goes to stderr
    told = err.index(" MB of texels")  # as planned; what the error makes of it is known after the transforms
    assert err.index("transforms") < err.index(f"{data['bytes'] / 1e6:.0f} MB of texels\n", told + 1)
    assert told < err.index("transforms")  # the size is told before the work


def test_command_line_and_python_give_the_same_bytes(run, grating, tmp_path):
    run("bake", grating, "--out", tmp_path / "cli", "--level", "plane", "--clip", "99.5", "--sigma-s-um", "2")
    bake_file(grating, tmp_path / "py", BakeParameters(level="plane", clip_percent=99.5, sigma_s_m=2e-6))
    for name in ("grating.exr", "grating.json"):
        assert (tmp_path / "cli" / name).read_bytes() == (tmp_path / "py" / name).read_bytes()


def test_eval_agrees_with_direct(run, grating, table):
    angles = ("--wi", "10", "20", "--wr", "-25", "8")
    _, fast, _ = run("eval", table, *angles, "--json")
    _, exact, _ = run("direct", grating, *angles, "--json")
    assert fast["xyz"] == pytest.approx(exact["xyz"], rel=0.03)
    _, one, _ = run("direct", grating, *angles, "--wavelength-nm", "550", "--json")
    assert one["f"] > 0


def test_map_is_a_picture_with_its_peak_in_the_mirror(run, table, tmp_path):
    import OpenEXR
    from PIL import Image

    for suffix in ("png", "exr"):
        code, data, _ = run(
            "map", table, "--theta-i", 30, "--phi-i", 0, "--out", tmp_path / f"m.{suffix}", "--size", 81, "--json"
        )
        assert code == 0 and data["out"].endswith(suffix)
    with Image.open(tmp_path / "m.png") as picture:
        assert picture.size == (81, 81)
    with OpenEXR.File(str(tmp_path / "m.exr")) as image:
        luminance = image.channels()["RGB"].pixels.sum(-1)
    row, col = np.unravel_index(luminance.argmax(), luminance.shape)
    x, y = (col + 0.5) / 81 * 2 - 1, 1 - (row + 0.5) / 81 * 2
    assert (x, y) == pytest.approx((-0.5, 0.0), abs=0.05)


def test_mirrored_blazed_preset_is_the_other_one_reversed(run, tmp_path):
    arguments = ("--size-um", "10", "--pixels", "100", "--period-um", "2.5", "--depth-nm", "250")
    run("preset", "blazed", "--out", tmp_path / "a.gsf", *arguments)
    run("preset", "blazed", "--out", tmp_path / "b.gsf", *arguments, "--mirror")
    a, b = read_scan(tmp_path / "a.gsf"), read_scan(tmp_path / "b.gsf")
    x = (np.arange(100) + 0.5) * 0.1
    assert a.heights[0] == pytest.approx(250e-9 * ((x / 2.5) % 1.0), abs=1e-13)
    assert (b.heights == a.heights[:, ::-1]).all()


def write(path, data):
    path.write_bytes(data) if isinstance(data, bytes) else path.write_text(data)
    return path


BAD_SCANS = {
    "missing.gsf": None,
    "empty.gsf": b"",
    "unknown.xyz": b"\x00\x01\x02 nothing known",
    "no_unit.txt": "1 2 3\n4 5 6\n7 8 9\n",
    "one_pixel.txt": "# Width: 1 um\n# Height: 1 um\n# Value units: m\n1e-9\n",
    "nan.txt": "# Width: 1 um\n# Height: 1 um\n# Value units: m\n1e-9 inf\n1e-9 2e-9\n",
    "cut.gsf": b"Gwyddion Simple Field 1.0\nXRes = 1000\nYRes = 1000\n\0\0\0\0",
}


@pytest.mark.parametrize("name", BAD_SCANS)
@pytest.mark.parametrize("command", ["info", "bake", "direct"])
def test_bad_scans_end_with_one_sentence(run, tmp_path, name, command):
    path = tmp_path / name
    if BAD_SCANS[name] is not None:
        write(path, BAD_SCANS[name])
    extra = {"info": (), "bake": ("--out", tmp_path / "out"), "direct": ("--wi", "0", "0", "--wr", "10", "0")}[command]
    before = sorted(tmp_path.rglob("*"))
    code, data, err = run(command, path, *extra, "--json")
    sentence = err.strip().splitlines()[-1]
    assert (code, data) == (2, None)
    assert sentence.endswith(".") and "Traceback" not in err and len(sentence) < 400
    assert [p for p in sorted(tmp_path.rglob("*")) if p.is_file()] == [p for p in before if p.is_file()]


@pytest.mark.parametrize(
    "options",
    [
        ("--size-um", "0", "5"), ("--size-um", "-1", "5"),
        ("--sigma-s-um", "0"), ("--sigma-s-um", "-2"), ("--tolerance", "0"),
        ("--clip", "0"), ("--clip", "101"), ("--level", "cubic"), ("--ensemble", "none"), ("--series", "fourier"),
        ("--sigma-s-um", "nan"), ("--limit-mb", "0.001"),
    ],
)  # fmt: skip
def test_bad_options_end_with_one_sentence(run, grating, tmp_path, options):
    code, data, err = run("bake", grating, "--out", tmp_path / "out", *options, "--json")
    assert (code, data) == (2, None)
    assert err.strip().splitlines()[-1].endswith(".")
    assert not list(tmp_path.rglob("*.exr"))


def test_unwritable_folder_and_other_versions_are_said(run, grating, table, tmp_path):
    code, _, err = run("bake", grating, "--out", write(tmp_path / "file", "in the way"))
    assert code == 2 and "file" in err
    other = tmp_path / "other.json"
    sidecar = json.loads(table.with_suffix(".json").read_text())
    other.write_text(json.dumps({**sidecar, "format_version": 7}))
    (tmp_path / "other.exr").write_bytes(table.read_bytes())
    code, data, err = run("eval", tmp_path / "other.exr", "--wi", 0, 0, "--wr", 1, 1, "--json")
    assert (code, data) == (2, None) and "version 7" in err


def test_directions_below_the_surface_are_dark_or_refused(run, table):
    code, data, err = run("eval", table, "--wi", 0, 0, "--wr", 100, 0, "--json")
    assert code == 2 or data["xyz"] == [0, 0, 0]
    assert code == 0 or err.strip().endswith(".")


def test_it_is_a_module_that_runs(root_dir, grating):
    done = subprocess.run(
        [sys.executable, "-m", "precompute", "info", grating], cwd=root_dir, capture_output=True, text=True
    )
    assert done.returncode == 0 and "200 x 200" in done.stdout
    bad = subprocess.run([sys.executable, "-m", "precompute", "info"], cwd=root_dir, capture_output=True, text=True)
    assert bad.returncode == 2 and len(bad.stderr.strip().splitlines()) == 1
