# SPDX-License-Identifier: GPL-3.0-or-later
"""What keeps a scene from its colours is said: on the console before a render, in the panel, by *Check Files*."""

import bpy
import numpy as np
import pytest

from tests.support.blender import panels, scenes


@pytest.fixture
def plane(blender, tmp_path):
    """A plane with an OSL material of a table under a sun, before the camera."""
    ob = scenes.plane_with_table(tmp_path)
    scenes.add_camera()
    apply("OSL")
    return ob


def apply(implementation):
    bpy.ops.diffraction.apply_material(implementation=implementation, fresnel="NONE", environment=0)


def said(capsys):
    """The console's lines of a render."""
    capsys.readouterr()
    scenes.render(8)
    return [line for line in capsys.readouterr().out.splitlines() if line.startswith("Diffraction: ")]


def in_the_panel():
    return panels.words(panels.shown("main")).removeprefix("test").strip()


def test_nothing_is_said_where_all_is_well(plane, capsys):
    assert said(capsys) == []
    assert in_the_panel() == ""
    assert bpy.ops.diffraction.check_files(strict=True) == {"FINISHED"}


def test_osl_switched_off_is_said_and_shows_the_pigment(plane, capsys):
    """As render presets do."""
    node = plane.active_material.node_tree.nodes["Diffraction"]
    node.inputs["Mask"].default_value = 0.0
    alone = scenes.render(8)
    node.inputs["Mask"].default_value = 1.0
    bpy.context.scene.cycles.shading_system = False
    (line,) = said(capsys)
    assert "Open Shading Language is off" in line and plane.active_material.name in line
    assert alone.max() > 1e-3
    np.testing.assert_allclose(scenes.render(8), alone, rtol=1e-4)
    assert "Open Shading Language is off" in panels.words(panels.shown("material"))
    bpy.context.scene.cycles.shading_system = True
    assert scenes.render(8).mean() > 2 * alone.mean()


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_simplify_is_named(plane, capsys, implementation):
    apply(implementation)
    scene = bpy.context.scene
    if implementation == "OSL" and bpy.app.version < (5, 2, 0):
        pytest.skip("OSL of Blender before 5.2 reads its files by itself")
    scene.cycles.texture_limit_render = "128"
    assert said(capsys) == []  # Simplify itself is off
    scene.render.use_simplify = True
    (line,) = said(capsys)
    assert "Simplify > Render Texture Limit shrinks the tables" in line
    assert "Simplify > Render Texture Limit" in in_the_panel()
    scene.cycles.texture_limit_render, scene.cycles.texture_limit = "OFF", "128"
    assert said(capsys) == []
    assert "Simplify > Viewport Texture Limit" in in_the_panel()
    scene.cycles.texture_limit = "8192"
    assert in_the_panel() == ""


def test_a_resolution_is_named(plane, capsys):
    scene = bpy.context.scene
    if not hasattr(scene.cycles, "texture_resolution_render"):
        pytest.skip("this Blender has no Texture Resolution")
    scene.render.use_simplify, scene.cycles.texture_resolution_render = True, 0.5
    (line,) = said(capsys)
    assert "Simplify > Render Texture Resolution shrinks the tables" in line


def test_a_missing_table_is_said(plane, capsys, tmp_path):
    (tmp_path / "diffraction" / "t.exr").unlink()
    (line,) = said(capsys)
    assert "t.exr is not in" in line
    with pytest.raises(RuntimeError, match=r"1 fault: .*t\.exr is not in"):
        bpy.ops.diffraction.check_files(strict=True)
    assert bpy.ops.diffraction.check_files() == {"FINISHED"}


def atlas(plane):
    return plane.active_material.node_tree.nodes["Diffraction"].node_tree["diffraction_atlas"]


def test_a_colour_space_by_hand_is_said(plane, capsys):
    apply("NODES")
    atlas(plane).colorspace_settings.name = "sRGB"
    (line,) = said(capsys)
    assert "has the colour space sRGB" in line and "does not diffract" in line
    assert "has the colour space sRGB" in in_the_panel()


def test_a_resized_image_is_said(plane, capsys):
    apply("NODES")
    image = atlas(plane)
    size = tuple(image.size)
    image.scale(size[0] // 2, size[1] // 2)
    (line,) = said(capsys)
    assert f"was resized from {size[0]} x {size[1]} to {size[0] // 2} x {size[1] // 2}" in line


def test_a_packed_png_is_said(plane, capsys, tmp_path):
    apply("NODES")
    image = atlas(plane)
    made = bpy.data.images.new("small", 8, 8)
    made.filepath_raw, made.file_format = str(tmp_path / "small.png"), "PNG"
    made.save()
    data = (tmp_path / "small.png").read_bytes()
    image.pack(data=data, data_len=len(data))
    lines = said(capsys)
    assert any("was packed as another format than EXR" in line for line in lines)
