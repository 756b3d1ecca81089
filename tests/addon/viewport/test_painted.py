# SPDX-License-Identifier: GPL-3.0-or-later
"""Scale, Depth and Mask in the viewport: constants and a paint, pixel by pixel what numpy says."""

import bpy
import numpy as np
import pytest

from precompute.evaluate.scaled import ScaledTable
from precompute.light.colour import xyz_to_rgb_matrix
from precompute.paint import Paint, save_paint
from tests.support.blender import drawing, scenes, tables
from tests.support.blender import viewport_scene as scene
from tests.support.compare import assert_images_agree
from tests.truth import radiance

SUN = np.array([0.5, 0.3, 2.0]) / np.linalg.norm([0.5, 0.3, 2.0])


@pytest.mark.parametrize("conserve", [False, True])
def test_constants_are_those_of_the_scaled_table(renderer, tmp_path, conserve):
    table = tables.make_table(tmp_path / "t.exr", tables.lobes, albedo=tables.rising)
    sphere = scenes.add_sphere(segments=256, rings=128)
    scenes.add_sun(SUN, strength=2.0)
    scenes.add_camera(direction=(0.4, -0.2, 1.0))
    made = scene.give_material(sphere, tmp_path / "t.exr", fresnel="NONE", conserve_energy=conserve)
    node = (made or sphere.active_material).node_tree.nodes["Diffraction"]
    node.inputs["Scale"].default_value, node.inputs["Depth"].default_value = 0.7, 0.6
    node.inputs["Mask"].default_value = 0.5
    image = drawing.alone(renderer, 64)
    hit, _, t, b, n = scenes.sphere_frames(sphere, 64)
    wr = radiance.local(-scenes.camera_rays(64)[1], t, b, n)
    wi = radiance.local(SUN, t, b, n)
    f_cos = radiance.f_cos_xyz(ScaledTable(table, 0.7, 0.6), wi, wr, conserve)
    truth = radiance.gamut_step(f_cos, xyz_to_rgb_matrix("Linear Rec.709", "D65"))  # strength 2, mask 1 / 2
    good = hit & (wr[..., 2] > 0.15) & (wi[..., 2] > 0.1)
    assert good.sum() > 1000
    assert_images_agree(image[..., :3], truth, 0.01, 98, where=good, name=f"viewport_scaled_{conserve}")


def test_a_paint_is_followed_texel_by_texel(renderer, tmp_path):
    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    random = np.random.default_rng(3)
    scale, depth, mask = random.uniform(0.4, 1.0, (3, 8, 8))
    rotation = random.uniform(0.0, 6.0, (8, 8))
    path = save_paint(Paint(scale, depth, rotation, mask), tmp_path / "p.exr")
    plane = scenes.add_plane(half=1.0)
    scenes.add_sun(SUN, strength=1.0)
    scenes.add_camera(direction=(0.0, 0.0, 1.0), extent=2.0)
    made = scene.give_material(plane, tmp_path / "t.exr", fresnel="NONE", conserve_energy=False)
    from diffraction_shader.addon.materials.node import paint_nodes

    paint_nodes.wire(made or plane.active_material, paint_nodes.load(path))
    image = drawing.alone(renderer, 64)[4::8, 4::8, :3][::-1, ::-1]  # straight above: top down
    wr, truth = np.array([0.0, 0.0, 1.0]), np.zeros((8, 8, 3))
    for place in np.ndindex(8, 8):
        one = ScaledTable(table, scale[place], depth[place], rotation[place])
        f_cos = mask[place] * radiance.f_cos_xyz(one, SUN, wr, conserve=False)
        truth[place] = radiance.gamut_step(f_cos[None], xyz_to_rgb_matrix("Linear Rec.709", "D65"))[0]
    assert_images_agree(image, truth, 0.01, name="viewport_painted")
    assert bpy.data.images["p"].size[:] == (8, 8)
