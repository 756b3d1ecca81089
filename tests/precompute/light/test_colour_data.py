# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers that are kept from colour-science are colour-science's, and suffice for a bake and a map."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from precompute.light import colour_data
from tools.build.colour_data import collect

ROOT = Path(__file__).resolve().parents[3]


def test_the_file_holds_what_colour_science_holds():
    """To the last bit; where this fails after an update of the library, tools/build/colour_data.py writes it anew."""
    assert json.loads(colour_data.PATH.read_text(encoding="utf-8")) == collect()


def test_observer_and_illuminants_cover_the_visible_range():
    nm, cmfs = colour_data.observer()
    assert (nm[0], nm[-1], cmfs.shape) == (380.0, 780.0, (401, 3))
    assert nm[cmfs[:, 1].argmax()] == pytest.approx(555.0)
    for name in ("D65", "D50", "A", "E", "FL11"):
        at, power = colour_data.illuminant(name)
        assert (at[0], at[-1]) == (380.0, 780.0)
        assert at.shape == power.shape and np.interp(560.0, at, power) > 0.0


PROGRAM = """
import sys
from precompute.bake import bake
from precompute.evaluate import brdf_map, map_to_srgb
from precompute.light import xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.light.illuminant import ILLUMINANTS

for illuminant in ILLUMINANTS:
    table = bake(make_preset("sinusoid", 6e-6, 64), BakeParameters(detail=0.2, illuminant=illuminant))
    map_to_srgb(brdf_map(table, (0.0, 0.0, 1.0), 8), illuminant=illuminant)
    for space in ("Linear Rec.709", "Linear Rec.2020", "ACEScg"):
        xyz_to_rgb_matrix(space, illuminant)
print(sorted({name.partition(".")[0] for name in sys.modules} & {"colour", "matplotlib", "pandas"}))
"""


def test_a_bake_and_its_map_do_without_the_library():
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
