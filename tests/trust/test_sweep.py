# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps: all combinations, resume, faults that stay with their scan, and a worker that is killed."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from precompute.bake.baking import bake_file
from precompute.errors import ParameterError
from precompute.parameters import BakeParameters
from precompute.scan.gsf import write_gsf
from precompute.sweep import make_tasks, sweep
from precompute.table.table import SpectralTable
from tests.support.trust.tables import small_scan

ROOT = Path(__file__).resolve().parents[2]
BASE = BakeParameters(sigma_s_m=0.5e-6, detail=0.5)


@pytest.fixture
def scans(tmp_path):
    (tmp_path / "scans").mkdir()
    return [write_gsf(small_scan(n), tmp_path / "scans" / f"scan{n}.gsf") for n in range(2)]


def command(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "precompute", "sweep", *map(str, arguments)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        **options,
    )


def test_all_combinations_have_names_of_their_own(scans):
    tasks = make_tasks(scans, BASE, {"sigma_s_m": [0.5e-6, 1e-6], "level": ["none", "plane"], "ensemble": ["average"]})
    assert [task.name for task in tasks] == [
        f"scan{n}_s-{sigma}_{level}" for n in (0, 1) for sigma in ("0.5", "1") for level in ("none", "plane")
    ]
    assert {(t.path, t.parameters.sigma_s_m, t.parameters.level) for t in tasks} == {
        (str(path), sigma, level) for path in scans for sigma in (0.5e-6, 1e-6) for level in ("none", "plane")
    }


def test_one_name_for_two_tables_is_refused(scans):
    with pytest.raises(ParameterError, match="'scan0'"):
        make_tasks([scans[0], scans[0]], BASE, {})
    with pytest.raises(ParameterError, match="no value twice"):
        make_tasks(scans, BASE, {"sigma_s_m": [1e-6, 1e-6]})


def test_a_sweep_makes_the_tables_of_single_bakes_and_resumes(tmp_path, scans):
    tasks = make_tasks(scans, BASE, {"sigma_s_m": [0.5e-6, 0.6e-6]})
    heard = []
    first = sweep(tasks, tmp_path / "out", workers=0, progress=lambda text, done: heard.append(done))
    assert [outcome.state for outcome in first] == ["baked"] * 4
    assert heard == [0.25, 0.5, 0.75, 1.0]
    for task in tasks:
        bake_file(task.path, tmp_path / "single", task.parameters, name=task.name)
        for suffix in (".exr", ".json"):
            one, other = ((tmp_path / folder / (task.name + suffix)).read_bytes() for folder in ("out", "single"))
            assert one == other
    # One is lost, one damaged, one belongs to another scan: those three are baked again, bit for bit.
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    names = [task.name for task in tasks]
    (tmp_path / "out" / f"{names[0]}.exr").unlink()
    damaged = bytearray(before[f"{names[1]}.exr"])
    damaged[-10] ^= 1
    (tmp_path / "out" / f"{names[1]}.exr").write_bytes(bytes(damaged))
    for suffix in (".exr", ".json"):
        (tmp_path / "out" / (names[2] + suffix)).write_bytes(before[names[3] + suffix])
    again = sweep(tasks, tmp_path / "out", workers=0)
    assert [outcome.state for outcome in again] == ["baked", "baked", "baked", "skipped"]
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


def test_a_sweep_takes_tables_from_a_cache(tmp_path, scans):
    tasks = make_tasks(scans, BASE, {})
    sweep(tasks, tmp_path / "one", workers=0, cache_dir=tmp_path / "cache")
    states = [o.state for o in sweep(tasks, tmp_path / "two", workers=0, cache_dir=tmp_path / "cache")]
    assert states == ["cached", "cached"]


def test_a_bad_scan_stops_no_other_and_is_named(tmp_path, scans):
    bad = tmp_path / "scans" / "bad.gsf"
    bad.write_bytes(b"Gwyddion Simple Field 1.0\n")
    done = command(bad, *scans, "--out", tmp_path / "out", "--workers", 0, "--detail", 0.5, "--sigma-s-um", 0.5)
    assert done.returncode == 2
    assert done.stderr.strip().splitlines()[-1].startswith("1 of 3 bakes failed")
    assert "bad.gsf" in done.stderr
    for scan in scans:
        SpectralTable.load(tmp_path / "out" / f"{scan.stem}.exr")
    report = json.loads((tmp_path / "out" / "sweep.json").read_text())
    assert [bool(entry["error"]) for entry in report] == [True, False, False]


def test_without_dask_the_package_is_named(tmp_path, scans):
    block = (
        "import sys; sys.modules['distributed'] = None; from precompute.cli import main; sys.exit(main(sys.argv[1:]))"
    )
    arguments = ["sweep", str(scans[0]), "--out", str(tmp_path / "out")]
    done = subprocess.run(
        [sys.executable, "-c", block, *arguments], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "'distributed'" in done.stderr and "--workers 0" in done.stderr


def test_no_scheduler_at_the_address(tmp_path, scans, monkeypatch):
    distributed = pytest.importorskip("distributed")

    def nobody(address, timeout):
        raise OSError(f"Timed out trying to connect to {address}")

    monkeypatch.setattr(distributed, "Client", nobody)
    with pytest.raises(ParameterError, match=r"No dask scheduler answers at 'tcp://127\.0\.0\.1:1'"):
        sweep(make_tasks(scans, BASE, {}), tmp_path / "out", scheduler="tcp://127.0.0.1:1")


def test_a_running_scheduler_is_used(tmp_path, scans):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None, protocol="tcp"
    ) as cluster:
        tasks = make_tasks(scans, BASE, {})
        outcomes = sweep(tasks, tmp_path / "out", scheduler=cluster.scheduler_address)
    assert [outcome.state for outcome in outcomes] == ["baked", "baked"]


@pytest.mark.slow
def test_a_killed_worker_costs_nothing_but_time(tmp_path):
    """24 scans on two workers, one of which is killed while it works: 24 right tables, no leftovers."""
    psutil = pytest.importorskip("psutil")
    pytest.importorskip("distributed")
    scans = [write_gsf(small_scan(n, 96), tmp_path / f"scan{n:02d}.gsf") for n in range(24)]
    out = tmp_path / "out"
    arguments = ["sweep", *map(str, scans), "--out", str(out), "--sigma-s-um", "0.6", "--workers", "2", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "precompute", *arguments],
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    end = time.monotonic() + 120
    while not list(out.glob("scan*.json")) and time.monotonic() < end:
        time.sleep(0.05)
    workers = [p for p in psutil.Process(process.pid).children() if "spawn_main" in " ".join(p.cmdline())]
    assert len(workers) == 2
    done_before = len(list(out.glob("scan*.json")))
    os.kill(workers[0].pid, signal.SIGKILL)
    output, errors = process.communicate(timeout=300)
    assert process.returncode == 0, errors
    assert 1 <= done_before < 20
    assert json.loads(output)["baked"] == 24
    parameters = BakeParameters(sigma_s_m=0.6e-6)
    for scan in scans:
        bake_file(scan, tmp_path / "single", parameters)
        for suffix in (".exr", ".json"):
            name = scan.stem + suffix
            assert (out / name).read_bytes() == (tmp_path / "single" / name).read_bytes()
    left = {path.name for path in out.iterdir() if not path.name.startswith(".tmp-")}
    assert left == {"sweep.json", *(s.stem + suffix for s in scans for suffix in (".exr", ".json"))}
