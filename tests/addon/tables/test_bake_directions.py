# SPDX-License-Identifier: GPL-3.0-or-later
"""The image of directions is made by the bake, in its thread: Apply and what follows a bake do not wait for it."""

import bpy
import pytest

from tests.support.blender import scenes


@pytest.fixture
def scan(blender, tmp_path):
    """A saved file with a small scan."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=8, pixels=64)
    return tmp_path


def test_each_bake_makes_it_once_and_apply_finds_it(scan, monkeypatch):
    from diffraction_shader.precompute.table import importance

    made = []
    original = importance.importance
    monkeypatch.setattr(importance, "importance", lambda table: made.append(table) or original(table))
    plane = scenes.add_plane()
    for count, detail in enumerate((0.2, 0.25), 1):  # the second bake brings the material up to date as well
        assert bpy.ops.diffraction.bake(detail=detail) == {"FINISHED"}
        assert len(made) == count and (scan / "diffraction" / "sinusoid.importance.exr").is_file()
        plane.select_set(True)
        bpy.context.view_layer.objects.active = plane
        assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
        assert len(made) == count


def test_a_table_from_elsewhere_gets_it_from_apply(scan):
    bpy.ops.diffraction.bake(detail=0.2)
    image = scan / "diffraction" / "sinusoid.importance.exr"
    image.unlink()
    scenes.add_plane().select_set(True)
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    assert image.is_file()
