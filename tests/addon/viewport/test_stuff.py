# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport draws tables that hold a film or a lacquer as numpy evaluates them."""

import subprocess
import sys


def test_spheres_are_those_of_numpy(root_dir):
    """In a process of its own, as in `test_masks.py`: after many other tests a lacquer's mirror was once not drawn."""
    case = "tests/addon/viewport/layered.py"
    command = [sys.executable, "-m", "pytest", "--quiet", "-p", "no:xdist", "-p", "no:cacheprovider", case]
    done = subprocess.run(command, cwd=root_dir, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "4 passed" in done.stdout or "4 skipped" in done.stdout
