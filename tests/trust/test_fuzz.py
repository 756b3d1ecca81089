# SPDX-License-Identifier: GPL-3.0-or-later
"""Every reader and the loaders of tables and terms under damaged files: a result or one sentence.

A case may neither crash the process, take 5 s, want more than 1 GiB, nor raise anything but a
``DiffractionError``; see ``tests/support/trust/fuzz.py``.
"""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from precompute.readers.formats import FORMATS
from tests.support import more_scan_files
from tests.support.trust import seeds

ROOT = Path(__file__).resolve().parents[2]
TARGETS = (*seeds.NAMES, "table", "terms")


@pytest.fixture
def folder(tmp_path):
    """A folder in memory where there is one: each case is a file."""
    memory = Path("/dev/shm")
    if not os.access(memory, os.W_OK):
        yield tmp_path
        return
    made = Path(tempfile.mkdtemp(prefix="fuzz-", dir=memory))
    yield made
    shutil.rmtree(made)


def fuzz(cases, folder, *names, seed=1):
    arguments = [sys.executable, "-m", "tests.support.trust.fuzz", str(cases), str(folder), str(seed), *map(str, names)]
    done = subprocess.run(arguments, cwd=ROOT, capture_output=True, text=True, errors="replace", check=False)
    if done.returncode != 0:
        kept = ROOT / "out" / "fuzz"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(folder, kept)
        why = "a case took too long" if done.returncode == -14 else done.stderr[-3000:]
        pytest.fail(f"{' '.join(map(str, names))}: exit code {done.returncode}; the case is in {kept}; {why}")
    return json.loads(done.stdout.splitlines()[-1])  # libraries in C print what they think


def test_every_format_has_seeds():
    without = set() if seeds.HAS_HDF else set(more_scan_files.HDF)
    assert {form.name for form in FORMATS} - without <= set(seeds.NAMES)


def test_a_few_hundred_cases_a_reader(folder):
    results = fuzz(200, folder, *TARGETS)
    assert set(results) == set(TARGETS)
    for name, result in results.items():
        assert result["read"] + result["refused"] >= 200
        # Damage that never hurts, or always, would test one path only.
        assert result["read"] and result["refused"], name


@pytest.mark.thorough
@pytest.mark.parametrize("name", TARGETS)
def test_ten_thousand_cases(folder, name):
    result = fuzz(10_000, folder, name, seed=2)[name]
    print(name, result)
    assert result["read"] + result["refused"] >= 10_000


@pytest.mark.thorough
def test_real_files(scan_dir, folder):
    files = [path for path in sorted(scan_dir.iterdir()) if path.is_file() and path.suffix != ".md"]
    if not files:
        pytest.skip(f"{scan_dir} holds no scans")
    for path in files:
        result = fuzz(300, folder, path)[str(path)]
        print(path.name, result)
        assert result["refused"]


def test_the_harness_notices_what_it_is_for(folder):
    """A reader that crashes, hangs, takes memory or raises its own error ends the run."""
    program = """
import sys
import precompute.readers as readers
from tests.support.trust import fuzz

def crash(path): import os, signal; os.kill(os.getpid(), signal.SIGSEGV)
def hang(path):
    while True: pass
def take(path): bytearray(2 << 30)
def error(path): raise KeyError("x")

bad = {"crash": crash, "hang": hang, "take": take, "error": error}[sys.argv.pop()]
real, state = readers.read_scan, {"calls": 0}
def fake(path, **options):
    state["calls"] += 1
    if state["calls"] < 5:
        return real(path, **options)
    with readers._Sentences(path) if bad is take else memoryview(b""):
        bad(path)
readers.read_scan = fake
fuzz.LIMIT_SECONDS = 0.5
fuzz.main(sys.argv[1:])
"""
    for kind, code in (("crash", -11), ("hang", -14), ("take", 1), ("error", 1)):
        arguments = [sys.executable, "-c", program, "50", str(folder), "1", "gsf", kind]
        done = subprocess.run(arguments, cwd=ROOT, capture_output=True, text=True, errors="replace", check=False)
        assert done.returncode == code, (kind, done.stderr[-500:])
