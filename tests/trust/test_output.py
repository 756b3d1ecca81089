# SPDX-License-Identifier: GPL-3.0-or-later
"""Where results cannot be written, and where they must not be: full disks, closed folders, long names, other places."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from precompute.bake.baking import bake_file
from precompute.cli import main
from precompute.errors import DiffractionError, OutputError, ScanError
from precompute.parameters import BakeParameters
from precompute.readers import read_scan
from precompute.scan.gsf import write_gsf
from precompute.table.table import SpectralTable
from tests.support.trust.tables import small_scan, small_table

ROOT = Path(__file__).resolve().parents[2]
PARAMETERS = BakeParameters(sigma_s_m=0.5e-6, detail=0.5)

#: Writes each kind of file into argv[1] while no file may grow beyond argv[2] bytes.
FULL = """
import json, resource, sys
from pathlib import Path
import numpy as np
from precompute.errors import DiffractionError
from precompute.scan.gsf import write_gsf
from precompute.files.images import write_exr, write_png
from precompute.table.importance import save_importance
from precompute.parameters import BakeParameters
from precompute.bake.terms import save_terms
from tests.support.trust.tables import small_scan, small_table

folder, limit = Path(sys.argv[1]), int(sys.argv[2])
scan, table = small_scan(1), small_table(1)
picture = np.random.default_rng(0).random((64, 64, 3))
writers = {
    "table": lambda: table.save(folder / "table.exr"),
    "atlas": lambda: table.save_atlas(folder / "atlas.exr"),
    "scan": lambda: write_gsf(scan, folder / "scan.gsf"),
    "terms": lambda: save_terms(scan, BakeParameters(series="taylor", tolerance=0.1), folder / "t.exr"),
    "png": lambda: write_png(folder / "map.png", picture),
    "exr": lambda: write_exr(folder / "map.exr", picture),
    "importance": lambda: save_importance(picture.astype(np.float32), folder / "importance.exr", "0" * 64),
}
resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
results = {}
for name, write in writers.items():
    try:
        write()
        results[name] = "written"
    except DiffractionError as error:
        results[name] = f"{type(error).__name__}: {error}"
print(json.dumps(results))
"""


@pytest.mark.parametrize("limit", [0, 300, 5000])
def test_a_full_disk_is_told_and_leaves_nothing(tmp_path, limit):
    """EFBIG stands in for ENOSPC: both come from write, in Python and inside the image library."""
    out = tmp_path / "out"
    out.mkdir()
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(out), str(limit)], cwd=ROOT, capture_output=True, text=True, check=True
    )
    results = json.loads(done.stdout.splitlines()[-1])
    for name, result in results.items():
        assert result.startswith("OutputError: Cannot write"), (name, result)
        assert "File too large" in result and "has space" in result and result.endswith("."), (name, result)
    assert not [path for path in out.rglob("*") if path.is_file()]


def test_a_full_disk_leaves_the_old_files(tmp_path):
    out = tmp_path / "out"
    program = [sys.executable, "-c", FULL, str(out)]
    subprocess.run([*program, "100000000"], cwd=ROOT, check=True, capture_output=True)
    before = {path: path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()}
    assert len(before) >= 8
    subprocess.run([*program, "300"], cwd=ROOT, check=True, capture_output=True)
    assert {path: path.read_bytes() for path in sorted(out.rglob("*")) if path.is_file()} == before
    SpectralTable.load(out / "table.exr")


def test_a_bake_on_a_full_disk_is_one_sentence(tmp_path):
    scan = write_gsf(small_scan(1), tmp_path / "scan.gsf")
    program = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (2000, resource.getrlimit("
        "resource.RLIMIT_FSIZE)[1])); from precompute.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    arguments = ["bake", str(scan), "--out", str(tmp_path / "out"), "--sigma-s-um", "0.5", "--detail", "0.5"]
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1].startswith("Cannot write")
    assert "Traceback" not in done.stderr
    assert not list((tmp_path / "out").iterdir())


@pytest.mark.parametrize("closed", ["file in the way", "file above", "proc", "no permission"])
def test_folders_that_cannot_be_written(tmp_path, closed):
    if closed == "file in the way":
        (tmp_path / "out").write_bytes(b"")
        folder = tmp_path / "out"
    elif closed == "file above":
        (tmp_path / "file").write_bytes(b"")
        folder = tmp_path / "file" / "deep" / "out"
    elif closed == "proc":
        folder = Path("/proc/self/out")
        if not folder.parent.is_dir():
            pytest.skip("this system has no /proc")
    else:
        folder = tmp_path / "closed"
        folder.mkdir()
        folder.chmod(0o500)
        if os.access(folder, os.W_OK):
            pytest.skip("the superuser may write everywhere")
    scan = write_gsf(small_scan(1), tmp_path / "scan.gsf")
    for write in (
        lambda: bake_file(scan, folder, PARAMETERS),
        lambda: small_table(1).save(folder / "table.exr"),
        lambda: write_gsf(small_scan(1), folder / "scan.gsf"),
    ):
        with pytest.raises(OutputError) as caught:
            write()
        assert str(caught.value).endswith(".") and "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["Schlangenhäute", "蛇の鱗", "кожа змеи", "👁 e\u0301 \u202e", "a b'c\"d$e;f%s", "-x"])
def test_names_in_any_script(tmp_path, name):
    """From scan to table and back, with the folder and the file called so."""
    folder = tmp_path / name
    folder.mkdir()
    scan = write_gsf(small_scan(1), folder / f"{name}.gsf")
    report = bake_file(scan, folder / "out", PARAMETERS)
    assert report.path == folder / "out" / f"{name}.exr"
    again = SpectralTable.load(report.path)
    np.testing.assert_array_equal(again.atlas, report.table.atlas)
    assert again.info["source"]["name"] == f"{name}.gsf"


def test_the_longest_names(tmp_path):
    """255 bytes are the limit of a name: up to it all works, beyond it one sentence says so and nothing is left."""
    table, scan = small_table(1), small_scan(1)
    longest = tmp_path / ("x" * 250 + ".exr")
    table.save(longest)
    assert SpectralTable.load(longest).info["key"] == table.info["key"]
    out = tmp_path / "out"
    # The atlas' name fits, the sidecar's is one letter too long: neither may be there afterwards.
    for name in ("x" * 251 + ".exr", "x" * 300 + ".exr", "ä" * 200 + ".exr"):
        with pytest.raises(OutputError, match="Cannot write"):
            table.save(out / name)
    with pytest.raises(OutputError, match="Cannot write"):
        write_gsf(scan, out / ("x" * 300 + ".gsf"))
    assert not list(out.iterdir())


def test_the_longest_paths(tmp_path):
    deep = tmp_path.joinpath(*["d" * 200] * 30)
    for attempt in (lambda: small_table(1).save(deep / "t.exr"), lambda: write_gsf(small_scan(1), deep / "s.gsf")):
        with pytest.raises(OutputError):
            attempt()
    with pytest.raises(ScanError):
        read_scan(deep / "s.gsf")
    with pytest.raises(DiffractionError):
        SpectralTable.load(deep / "t.exr")


def test_command_line_says_it_in_one_line(tmp_path, capsys):
    scan = write_gsf(small_scan(1), tmp_path / "scan.gsf")
    (tmp_path / "file").write_bytes(b"")
    assert main(["bake", str(scan), "--out", str(tmp_path / "file" / "out")]) == 2
    assert capsys.readouterr().err.strip().splitlines()[-1].endswith("choose another folder.")


#: The whole command line under an audit hook: no socket, and nothing written but below argv[1].
WATCHED = """
import os, sys
inside = os.path.realpath(sys.argv[1])
faults = []

def outside(path):
    return not os.path.realpath(os.fsdecode(path)).startswith(inside + os.sep)

def watch(event, arguments):
    if event.startswith("socket.") and event != "socket.gethostname":
        faults.append((event, str(arguments)[:200]))
    elif event == "open":
        path, mode, flags = arguments
        writes = flags is not None and flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if writes and isinstance(path, (str, bytes)) and path != os.devnull and outside(path):
            faults.append((event, str(path)))
    elif event in ("os.mkdir", "os.remove", "os.rmdir", "os.rename", "os.link", "os.symlink", "os.truncate"):
        if any(outside(path) for path in arguments if isinstance(path, (str, bytes))):
            faults.append((event, str(arguments)[:200]))
    elif event == "subprocess.Popen" and os.path.basename(str(arguments[0])) == "ldconfig":
        pass  # the C library's own list of libraries, asked by threadpoolctl
    elif event in ("subprocess.Popen", "os.system", "os.exec", "urllib.Request"):
        faults.append((event, str(arguments)[:200]))

sys.addaudithook(watch)
from precompute.cli import main

out = os.path.join(inside, "out")
scan = os.path.join(out, "scan.gsf")
for arguments in (
    ["preset", "snake", "--out", scan, "--pixels", "48", "--size-um", "3"],
    ["info", scan],
    ["bake", scan, "--out", out, "--sigma-s-um", "0.5", "--detail", "0.5", "--cache", os.path.join(inside, "cache")],
    ["bake", scan, "--out", out, "--sigma-s-um", "0.5", "--detail", "0.5", "--series", "chebyshev"],
    ["sweep", scan, "--out", os.path.join(inside, "sweep"), "--sigma-s-um", "0.5", "--detail", "0.5", "--workers", "0"],
    ["eval", os.path.join(out, "scan.exr"), "--wi", "30", "0", "--wr", "10", "20"],
    ["direct", scan, "--sigma-s-um", "0.5", "--wi", "30", "0", "--wr", "10", "20", "--wavelength-nm", "500"],
    ["map", os.path.join(out, "scan.exr"), "--theta-i", "30", "--phi-i", "0", "--size", "32", "--out", os.path.join(out, "m.png")],
):
    assert main(arguments) == 0, arguments
assert not faults, faults
"""  # fmt: skip # noqa: E501


def test_no_network_and_no_file_outside_the_chosen_folders(tmp_path):
    """By an audit hook, and for what libraries in C do by what the folders hold that programs like to write to."""
    chosen, home, here = (tmp_path / name for name in ("chosen", "home", "here"))
    for folder in (chosen, home, here):
        folder.mkdir()
    private = ("HOME", "TMPDIR", "XDG_CACHE_HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "MPLCONFIGDIR", "LOCALAPPDATA")
    environment = {**os.environ, **dict.fromkeys(private, str(home)), "PYTHONPATH": str(ROOT)}
    environment["PYTHONDONTWRITEBYTECODE"] = "1"
    done = subprocess.run(
        [sys.executable, "-c", WATCHED, str(chosen)],
        cwd=here,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert not list(home.rglob("*")) and not list(here.rglob("*"))
    assert {path.name for path in chosen.iterdir()} == {"out", "cache", "sweep"}
    assert not list(chosen.rglob(".tmp-*"))
