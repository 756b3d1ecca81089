# SPDX-License-Identifier: GPL-3.0-or-later
"""With Persistent Data too a render shows the table that is there now, whoever wrote it."""

import bpy
import numpy as np
import pytest

from tests.support.blender import extension, materials, scenes, tables


@pytest.fixture
def ball(blender, tmp_path):
    """A sphere under a sun, and a path for a table."""
    sphere = scenes.add_sphere(segments=32, rings=16)
    scenes.add_sun((0.3, 0.1, 0.9))
    scenes.add_camera()
    bpy.context.scene.render.use_persistent_data = True
    return sphere, tmp_path / "t.exr"


def picture():
    """A render that changes no setting, which Blender would take for a change of the scene."""
    path = bpy.context.scene.render.filepath
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:]).reshape(-1, 4)[:, :3]
    bpy.data.images.remove(image)
    return pixels


def prepare(tmp_path):
    scenes.render(24)
    bpy.context.scene.render.filepath = str(tmp_path / "r.exr")
    return picture()


def twice(u, v, w):
    return 2.0 * tables.gentle(u, v, w)


def baked(path, transform, **size):
    """As *Bake* leaves it."""
    extension.load()
    from diffraction_shader.addon.materials import refresh

    tables.make_table(path, transform, **size)
    refresh.refresh(path, "{}")


def by_another_process(path, transform, **size):
    tables.make_table(path, transform, **size)


@pytest.mark.parametrize("implementation", ["OSL", pytest.param("NODES", marks=pytest.mark.slow)])
@pytest.mark.parametrize("how", [baked, by_another_process])
def test_persistent_data_shows_the_new_table(ball, tmp_path, how, implementation):
    """Again and again, with the same layout and with another one."""
    sphere, path = ball
    tables.make_table(path, tables.gentle)
    materials.diffracting(sphere, path, implementation, fresnel="NONE", environment=0)
    first = prepare(tmp_path)
    how(path, twice)
    np.testing.assert_allclose(picture(), 2.0 * first, rtol=0.01, atol=1e-3)
    how(path, tables.gentle)
    np.testing.assert_allclose(picture(), first, rtol=0.01, atol=1e-3)
    how(path, twice, n_r=80, n_phi=100)
    np.testing.assert_allclose(picture().mean(), 2.0 * first.mean(), rtol=0.02)


def test_a_spelling_is_another_name_of_the_same_file(tmp_path):
    extension.load()
    from diffraction_shader.addon.materials import spelling

    path = tmp_path / "t.exr"
    path.write_text("t")
    names = [spelling.spell(str(path), version) for version in range(40)]
    assert names[0] == str(path) and len(set(names)) == 40
    assert all(path.samefile(name) for name in names)
    assert spelling.spell("//diffraction/t.exr", 2) == "//diffraction/.//./t.exr"


def test_a_saved_file_holds_the_plain_name(ball, tmp_path):
    sphere, path = ball
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    tables.make_table(path, tables.gentle)
    made = materials.diffracting(sphere, path, fresnel="NONE", environment=0)
    baked(path, twice)
    script = made.node_tree.nodes["Diffraction"].node_tree.nodes["OSL"]
    assert script.inputs["Atlas"].default_value == "//.//t.exr"
    bpy.ops.wm.save_mainfile(compress=False)
    assert script.inputs["Atlas"].default_value == "//.//t.exr"  # this session goes on
    written = (tmp_path / "a.blend").read_bytes()
    assert b"//t.exr" in written and b".//t.exr" not in written
