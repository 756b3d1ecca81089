# SPDX-License-Identifier: GPL-3.0-or-later
"""Diffraction > Paint: the same image as the command line's and the call's, wired, undone, taken off again."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from precompute.cli import main
from precompute.files import write_png
from precompute.paint import RECIPES, load_paint, make_paint
from tests.support.blender import scenes

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def painted(blender, tmp_path):
    """The active material of a plane that shows a table."""
    bpy.context.preferences.edit.use_global_undo = True
    ob = scenes.plane_with_table(tmp_path)
    bpy.ops.diffraction.apply_material()
    return ob.active_material


@pytest.fixture
def photo(tmp_path):
    path = tmp_path / "photo.png"
    hue = np.linspace(0.0, 1.0, 24)
    write_png(path, np.stack(np.broadcast_arrays(hue, 1.0 - hue[:, None], 0.05), -1))
    return str(path)


def image_of(shaded):
    from diffraction_shader.addon.materials.node import paint_nodes

    return paint_nodes.image(shaded)


def file_of(shaded):
    return Path(bpy.path.abspath(image_of(shaded).filepath))


@pytest.mark.parametrize("recipe", list(RECIPES))
def test_operator_command_and_call_write_the_same_paint(painted, photo, tmp_path, recipe):
    count = RECIPES[recipe].pictures
    pictures = {"picture": photo, "second_picture": photo} if count == 2 else {"picture": photo} if count else {}
    assert bpy.ops.diffraction.paint(recipe=recipe, pixels=24, period_um=1.6, **pictures) == {"FINISHED"}
    by_operator = load_paint(file_of(painted))
    table = tmp_path / "diffraction" / "t.exr"
    assert file_of(painted).parent == table.parent
    words = ["paint", recipe, "--table", str(table), "--period-um", "1.6", "--pixels", "24", "--out",
             str(tmp_path / "c.exr")]  # fmt: skip
    assert main(words + (["--picture", *[photo] * count] if count else [])) == 0
    by_command = load_paint(tmp_path / "c.exr")
    from precompute.files.pictures import read_picture

    by_call = make_paint(recipe, 1.6e-6, 24, pictures=[read_picture(photo)] * count)
    for a, b, c in zip(by_operator.maps, by_command.maps, by_call.maps, strict=True):
        np.testing.assert_array_equal(a, b)
        np.testing.assert_array_equal(a, c)
    # What Blender read is what was written: row 0 at the bottom.
    image = image_of(painted)
    seen = np.empty(len(image.pixels), np.float32)
    image.pixels.foreach_get(seen)
    np.testing.assert_allclose(seen.reshape(*by_call.shape, 4), np.stack(by_call.maps, -1), rtol=1e-6, atol=1e-7)


def test_sockets_follow_the_image_by_closest_lookups(painted):
    bpy.ops.diffraction.paint(recipe="glitter", pixels=16, period_um=1.6)
    node = painted.node_tree.nodes["Diffraction"]
    assert all(node.inputs[name].is_linked for name in ("Scale", "Depth", "Rotation", "Mask"))
    picture = painted.node_tree.nodes["Diffraction Paint"]
    assert picture.interpolation == "Closest" and picture.image.colorspace_settings.is_data
    assert picture.image.alpha_mode == "CHANNEL_PACKED"


def test_the_panel_holds_where_the_script_says_nothing_and_again_after_a_change(painted):
    state = bpy.context.scene.diffraction.paint
    state.recipe, state.pixels, state.period_um, state.recipes.rings.bands = "rings", 32, 1.6, 5
    assert bpy.ops.diffraction.paint() == {"FINISHED"}
    first = file_of(painted)
    assert load_paint(first).info["settings"]["bands"] == 5
    state.recipes.rings.bands = 9
    assert bpy.ops.diffraction.paint() == {"FINISHED"}
    assert load_paint(file_of(painted)).info["settings"]["bands"] == 9
    assert first.is_file()  # what undo goes back to
    assert sum(node.name.startswith("Diffraction Paint") for node in painted.node_tree.nodes) == 2
    assert bpy.ops.diffraction.paint(bands=3) == {"FINISHED"}
    assert load_paint(file_of(painted)).info["settings"]["bands"] == 3 and state.recipes.rings.bands == 9


def test_turn_of_the_whole_stays(painted):
    node = painted.node_tree.nodes["Diffraction"]
    node.inputs["Rotation"].default_value = 0.7
    for _ in range(2):
        bpy.ops.diffraction.paint(recipe="rays", pixels=8, period_um=1.6)
    assert painted.node_tree.nodes["Diffraction Turn"].inputs[1].default_value == pytest.approx(0.7)
    assert bpy.ops.diffraction.remove_paint() == {"FINISHED"}
    assert image_of(painted) is None and not node.inputs["Scale"].is_linked
    assert node.inputs["Rotation"].default_value == pytest.approx(0.7)
    assert not bpy.ops.diffraction.remove_paint.poll()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"recipe": "rings"}, "does not say the period"),
        ({"recipe": "picture", "period_um": 1.6}, "takes one picture"),
        ({"recipe": "picture", "period_um": 1.6, "picture": "//nothing.png"}, "does not exist"),
    ],
)
def test_what_fails_says_so_and_leaves_all_as_it_was(painted, tmp_path, given, words):
    before = sorted(path.name for path in (tmp_path / "diffraction").iterdir())
    nodes = len(painted.node_tree.nodes)
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.diffraction.paint(**given)
    assert sorted(path.name for path in (tmp_path / "diffraction").iterdir()) == before
    assert len(painted.node_tree.nodes) == nodes and image_of(painted) is None


def test_a_preset_tells_its_period(tmp_path):
    from precompute.bake import bake
    from precompute.paint import paint_of_table, table_period
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    field = make_preset("sinusoid", 12e-6, 130, period_um=1.3)
    table = bake(field, BakeParameters(sigma_s_m=1e-6, detail=0.3))
    assert table_period(table.info) == pytest.approx(1.3e-6)
    info = {**table.info, "layout": table.layout.to_dict()}
    hue = np.ones((8, 8, 3)) * (0.1, 0.9, 0.1)
    assert paint_of_table("picture", info, 8, pictures=[hue]).info["settings"]["sigma_s_um"] == pytest.approx(1.0)


def test_undo_takes_back_what_was_painted_and_redo_brings_it_again(painted):
    name = painted.name
    bpy.ops.diffraction.paint(recipe="rings", pixels=16, period_um=1.6)
    first = file_of(painted)
    bpy.ops.ed.undo_push(message="before")
    bpy.ops.diffraction.paint(recipe="rays", pixels=16, period_um=1.6)
    second = file_of(painted)
    bpy.ops.ed.undo_push(message="Paint")
    assert second != first
    bpy.ops.ed.undo()
    shaded = bpy.data.materials[name]
    assert file_of(shaded) == first and first.is_file()
    assert load_paint(file_of(shaded)).info["recipe"] == "rings"
    bpy.ops.ed.redo()
    assert file_of(bpy.data.materials[name]) == second


def test_collected_files_hold_the_paint(painted, tmp_path):
    bpy.ops.diffraction.paint(recipe="glitter", pixels=16, period_um=1.6)
    there = file_of(painted)
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(elsewhere / "moved.blend"), relative_remap=True)
    assert bpy.ops.diffraction.collect_files() == {"FINISHED"}
    here = file_of(painted)
    assert here.is_relative_to(elsewhere) and here.name == there.name
    assert here.read_bytes() == there.read_bytes()
    assert image_of(painted).filepath.startswith("//")
    assert bpy.ops.diffraction.collect_files() == {"FINISHED"}
    assert file_of(painted) == here
