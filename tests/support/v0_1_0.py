# SPDX-License-Identifier: GPL-3.0-or-later
"""What version 0.1.0 left behind: tests/data/v0_1_0, and the script that made it."""

import importlib.util
import json
from pathlib import Path

FOLDER = Path(__file__).resolve().parents[1] / "data" / "v0_1_0"


def script():
    """The script that made the files, as a module: what it took down, it can take down of today's code."""
    spec = importlib.util.spec_from_file_location("make_v0_1_0", FOLDER / "make.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def recorded(name):
    """`expected.json` or `bakes.json`."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def picture(name):
    """What 0.1.0 rendered of a .blend: linear RGB, row 0 at the bottom."""
    import numpy as np
    import OpenEXR

    with OpenEXR.File(str(FOLDER / f"{name}.exr")) as file:
        return np.ascontiguousarray(file.channels()["RGB"].pixels[::-1], dtype=np.float64)
