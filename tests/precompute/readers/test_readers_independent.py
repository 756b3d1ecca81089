# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers against independent ones on files that the project did not write: ``make scan-files`` brings both.

See ``tests/support/independent.py``. Files that the tests themselves write are compared as well: there the other
reader judges the writer.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from precompute.errors import ScanError
from precompute.readers import read_scan

FOLDER = Path(__file__).resolve().parents[3] / "out" / "scan-files" / "cases"
CASES = json.loads((FOLDER / "cases.json").read_text()) if (FOLDER / "cases.json").is_file() else {}


@pytest.mark.skipif(not CASES, reason="out/scan-files is not there: `make scan-files` downloads it")
@pytest.mark.parametrize("name", sorted(CASES) or ["none"])
def test_the_same_as_an_independent_reader(name):
    """Heights to rounding (a constant apart, where programs count from another zero), orientation and sides."""
    case, expected = CASES[name], np.load(FOLDER / f"{name}.npz")
    try:
        field = read_scan(FOLDER / name, channel=case["channel"])
    except ScanError as error:
        if "h5py" in str(error):
            pytest.skip("h5py is not installed in this environment")
        raise
    heights = expected["heights"]
    assert field.shape == heights.shape
    np.testing.assert_array_equal(field.missing, np.isnan(heights))
    difference = (field.heights - heights)[~field.missing]
    assert np.ptp(difference) <= 2e-6 * np.nanmax(heights) - 2e-6 * np.nanmin(heights)
    assert field.size_m == pytest.approx(expected["size"], rel=1e-5)


@pytest.mark.skipif(not CASES, reason="out/scan-files is not there: `make scan-files` downloads it")
def test_formats_with_two_files_of_others():
    """The formats that docs/formats.md says were compared on files of others."""
    found = {}
    for name, case in CASES.items():
        if case["writer"] != "tests":
            ending = Path(name).suffix
            found[ending] = found.get(ending, 0) + 1
    wanted = {".gwy", ".ibw", ".spm", ".jpk", ".stp", ".top", ".sdf", ".sur", ".x3p", ".al3d", ".txt"}
    assert {ending for ending in wanted if found.get(ending, 0) < 2} == set()
