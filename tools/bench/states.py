# SPDX-License-Identifier: GPL-3.0-or-later
"""The code that is measured: this checkout, and beside it the state that its speed is compared with.

That state comes out of the history (`git archive`) into out/bench/. Both run in fresh processes of the same Python,
with compiled sources cached as on a user's second start.
"""

import json
import os
import subprocess
import sys
import tarfile
import time
from io import BytesIO
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
TASKS = Path(__file__).with_name("tasks.py")

#: The state before the work on speed.
BEFORE = "f889080"
FOLDER = ROOT / "out" / "bench"


def code_before():
    """The folder of the older state; None, with a line on standard output, where there is no history."""
    folder = FOLDER / BEFORE
    if (folder / "precompute").is_dir():
        return folder
    done = subprocess.run(["git", "archive", BEFORE, "precompute"], cwd=ROOT, capture_output=True, check=False)
    if done.returncode:
        print(f"No comparison with {BEFORE}: this checkout has no history that holds it.", flush=True)
        return None
    folder.mkdir(parents=True, exist_ok=True)
    with tarfile.open(fileobj=BytesIO(done.stdout)) as archive:
        archive.extractall(folder, filter="data")
    return folder


def environment(root):
    """Variables of a process that runs the code below ``root``."""
    variables = {**os.environ, "PYTHONPATH": str(root), "PYTHONPYCACHEPREFIX": str(FOLDER / "compiled")}
    variables.pop("PYTHONDONTWRITEBYTECODE", None)
    return variables


def task(root, name, **given):
    """Run a function of tasks.py on the code below ``root`` in a fresh Python; returns what it measured."""
    command = [sys.executable, str(TASKS), name, json.dumps(given)]
    done = subprocess.run(command, cwd=root, env=environment(root), stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def seconds_of(root, *words):
    """Wall-clock seconds of a Python process, from its start to its end."""
    start = time.perf_counter()
    done = subprocess.run(
        [sys.executable, *map(str, words)], cwd=root, env=environment(root), capture_output=True, text=True, check=False
    )
    seconds = time.perf_counter() - start
    if done.returncode:
        sys.exit(f"{' '.join(map(str, words))} failed:\n{done.stderr}")
    return seconds
