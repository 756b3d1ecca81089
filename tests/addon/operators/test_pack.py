# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables inside the .blend: what is carried, and what is said where it is not."""

import shutil

import bpy
import numpy as np
import pytest

from tests.support.blender import panels, scenes


@pytest.fixture
def plane(blender, tmp_path):
    """A plane with an OSL material of a table beside a saved file."""
    ob = scenes.plane_with_table(tmp_path)
    scenes.add_camera()
    bpy.ops.diffraction.apply_material(implementation="OSL", fresnel="NONE", environment=0)
    return ob


def test_a_save_says_what_the_file_needs(plane, capsys):
    capsys.readouterr()
    bpy.ops.wm.save_mainfile()
    assert "this file needs its folder diffraction/; Material > Files > Pack into .blend" in capsys.readouterr().out
    bpy.ops.wm.save_mainfile()
    assert "needs its folder" not in capsys.readouterr().out
    assert "needs its folder diffraction/" in panels.words(panels.shown("files"))


def test_packed_the_blend_alone_is_enough(plane, tmp_path, capsys):
    """Copied without its folder, opened with the extension; and unpacked beside it again."""
    before = scenes.render(16)
    assert bpy.ops.diffraction.pack() == {"FINISHED"}
    assert not bpy.ops.diffraction.pack.poll()
    (tmp_path / "alone").mkdir()
    alone = tmp_path / "alone" / "a.blend"
    bpy.ops.wm.save_mainfile()
    shutil.copy(bpy.data.filepath, alone)
    shutil.rmtree(tmp_path / "diffraction")
    capsys.readouterr()
    bpy.ops.wm.open_mainfile(filepath=str(alone))
    assert before.max() > 0.1
    np.testing.assert_allclose(scenes.render(16), before, rtol=1e-4, atol=1e-6)
    bpy.ops.wm.save_mainfile()
    assert "needs its folder" not in capsys.readouterr().out
    assert bpy.ops.diffraction.unpack() == {"FINISHED"}
    assert sorted(path.name for path in (alone.parent / "diffraction").iterdir()) == [
        "t.exr", "t.importance.exr", "t.json",
    ]  # fmt: skip
    np.testing.assert_allclose(scenes.render(16), before, rtol=1e-4, atol=1e-6)
    assert bpy.ops.diffraction.check_files(strict=True) == {"FINISHED"}


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_libraries_write_carries_what_is_packed(plane, tmp_path, implementation):
    bpy.ops.diffraction.apply_material(implementation=implementation, fresnel="NONE", environment=0)
    if implementation == "OSL":
        bpy.ops.diffraction.pack()
    before, name = scenes.render(16), plane.active_material.name
    (tmp_path / "shelf").mkdir()
    shelf = str(tmp_path / "shelf" / "m.blend")
    bpy.data.libraries.write(shelf, {plane.active_material})
    shutil.rmtree(tmp_path / "diffraction")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.scene.cycles.shading_system = implementation == "OSL"
    with bpy.data.libraries.load(shelf) as (_, into):
        into.materials = [name]
    ob = scenes.add_plane()
    scenes.add_sun((0.1, 0.2, 1.0))
    scenes.add_camera()
    ob.data.materials.append(into.materials[0])
    bpy.context.view_layer.update()
    np.testing.assert_allclose(scenes.render(16), before, rtol=1e-4, atol=1e-6)
