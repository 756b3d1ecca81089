# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport's picture of the sample snake looks like the one that Cycles renders without shadows."""

import importlib.util

import pytest


@pytest.mark.thorough
def test_snake_by_cycles_and_by_the_viewport(blender, root_dir, tmp_path):
    spec = importlib.util.spec_from_file_location(
        "viewport_pictures", root_dir / "tools" / "docs" / "viewport_pictures.py"
    )
    pictures = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(pictures)
    drawn, difference = pictures.compare(tmp_path, width=200, samples=200, viewport_samples=64, flss=False)
    assert drawn[0].std() > 0.1  # not two black pictures
    assert difference.mean() <= 2.0
