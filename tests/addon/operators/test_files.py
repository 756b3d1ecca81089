# SPDX-License-Identifier: GPL-3.0-or-later
"""What a saved file does without this add-on, elsewhere, and in other working spaces."""

import shutil
import subprocess
import sys

import bpy
import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import materials, scenes, tables

RENDER = """
import sys, bpy
bpy.ops.wm.open_mainfile(filepath=sys.argv[1], use_scripts=False)
assert not hasattr(bpy.types, "DIFFRACTION_OT_bake")
bpy.context.scene.frame_set(int(sys.argv[3]))
bpy.context.scene.render.filepath = sys.argv[2]
bpy.ops.render.render(write_still=True)
"""


def read(path):
    import OpenEXR

    with OpenEXR.File(str(path)) as image:
        return image.channels()["RGBA"].pixels[::-1, :, :3].astype(float)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_saved_file_renders_alike_without_the_addon_in_another_folder(blender, tmp_path, implementation):
    """In a fresh process with scripts off, the folder moved; the sun turns by animation of its parent.

    Nodes need no file beside the .blend.
    """
    folder = tmp_path / "made here"
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    tables.make_table(folder / "diffraction" / "t.exr", tables.lobes)
    plane = scenes.add_sphere(segments=96, rings=48)
    pivot = bpy.data.objects.new("pivot", None)
    bpy.context.scene.collection.objects.link(pivot)
    scenes.add_sun((0.3, 0.1, 0.9), parent=pivot)
    for frame, angle in ((1, 0.0), (11, 2.0)):
        pivot.rotation_euler = (0, 0, angle)
        pivot.keyframe_insert("rotation_euler", frame=frame)
    scenes.add_camera()
    path = folder / "diffraction" / "t.exr"
    materials.diffracting(plane, path, implementation=implementation, fresnel="NONE", environment=0)
    bpy.context.scene.frame_set(11)
    here = scenes.render(24)
    bpy.ops.wm.save_mainfile()
    if implementation == "NODES":
        shutil.rmtree(folder / "diffraction")
    moved = tmp_path / "moved there"
    shutil.move(folder, moved)
    subprocess.run(
        [sys.executable, "-c", RENDER, str(moved / "scene.blend"), str(tmp_path / "there.exr"), "11"],
        check=True, capture_output=True, cwd="/",
    )  # fmt: skip
    assert here.max() > 0.1
    assert np.array_equal(read(tmp_path / "there.exr"), here)


SPACES = ("Linear Rec.709", "Linear Rec.2020", "ACEScg")


def test_working_spaces_agree_in_xyz(blender, tmp_path):
    """The handler writes the new matrix by itself; within all gamuts the colours are the same."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere = scenes.add_sphere(segments=192, rings=96)
    scenes.add_sun((0.3, 0.1, 0.9))
    scenes.add_camera()
    materials.diffracting(sphere, tmp_path / "t.exr", fresnel="NONE", environment=0)
    in_xyz, inside = {}, None
    for space in SPACES:
        bpy.ops.wm.set_working_color_space(working_space=space, convert_colors=True)
        assert bpy.data.colorspace.working_space == space
        bpy.context.view_layer.update()
        image = scenes.render(48)
        here = image.min(-1) > 1e-3 * image.max(-1)
        inside = here if inside is None else inside & here
        in_xyz[space] = image @ np.linalg.inv(xyz_to_rgb_matrix(space)).T
    assert inside.sum() > 300
    reference = in_xyz[SPACES[0]][inside]
    for space in SPACES[1:]:
        error = np.linalg.norm(in_xyz[space][inside] - reference, axis=-1) / np.linalg.norm(reference, axis=-1)
        assert np.percentile(error, 99) < 0.005
    luminance = [in_xyz[space][..., 1] for space in SPACES]  # the gamut step keeps it everywhere
    assert luminance[1] == pytest.approx(luminance[0], rel=0.005, abs=1e-4)
    assert luminance[2] == pytest.approx(luminance[0], rel=0.005, abs=1e-4)
