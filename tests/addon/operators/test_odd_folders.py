# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders whose names Blender misreads."""

import os

import bpy
import pytest


@pytest.mark.skipif(os.sep == "\\", reason="a backslash parts folders here")
def test_a_backslash_in_a_folder_is_one_sentence(blender, tmp_path):
    """Blender takes it for a slash and finds no image there: said before a bake, not after."""
    folder = tmp_path / "a\\b c"
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "s.blend"))
    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=10)
    with pytest.raises(RuntimeError, match=r"below 'a\\b c', whose name holds a backslash; rename it") as caught:
        bpy.ops.diffraction.bake(detail=0.25)
    assert "Traceback" not in str(caught.value)
    assert not list(folder.rglob("*.exr"))
