# SPDX-License-Identifier: GPL-3.0-or-later
"""kill -9 at random moments: afterwards the old data or the new, never a mixture. See ``tests/support/trust/``."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")


def kill(kind, points, folder, seed):
    done = subprocess.run(
        [
            sys.executable,
            "-W",
            "ignore::DeprecationWarning",
            "-m",
            "tests.support.trust.kills",
            kind,
            str(points),
            folder,
            str(seed),
        ],
        cwd=ROOT,
        # A fork keeps only one thread, so the libraries may have no others.
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    print(kind, found)
    return found


@pytest.mark.parametrize("kind", ["table", "import", "cache", "bake"])
def test_a_dozen_moments(tmp_path, kind):
    found = kill(kind, 12, tmp_path, 1)
    assert found["old"] + found["new"] == 12


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("kind", "points"), [("table", 200), ("import", 200), ("bake", 200), ("cache", 100), ("terms", 60)]
)
def test_hundreds_of_moments(tmp_path, kind, points):
    found = kill(kind, points, tmp_path, 2)
    assert found["old"] + found["new"] == points
    # Otherwise no child died while there was something to lose.
    assert min(found["old"], found["new"]) >= points // 10
