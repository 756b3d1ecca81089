# SPDX-License-Identifier: GPL-3.0-or-later
"""The material without OSL: the same picture as the OSL one in Cycles, nearly so in EEVEE."""

import bpy
import numpy as np
import pytest

from tests.addon import materials, scenes, tables
from tests.addon.test_suns import rising
from tests.compare import assert_images_agree

SUNS = [(0.3, -0.4, 0.8), (-0.5, 0.6, 0.7)]


def two_suns(tmp_path, suns=SUNS, **mesh):
    tables.make_table(tmp_path / "t.exr", tables.lobes, albedo=rising)
    sphere = scenes.add_sphere(**mesh)
    for number, direction in enumerate(suns):
        scenes.add_sun(direction, name=f"sun {number}")
    scenes.add_camera((0.2, 0.1, 1.0))
    return sphere


def visible(image):
    """Pixels well above the weight at which Cycles drops a closure."""
    return image.max(-1) > 3e-3


@pytest.mark.parametrize(
    "settings",
    [
        {"fresnel": "NONE"},
        {"fresnel": "DIELECTRIC", "ior": 1.7, "rotation": 0.7},
        {"fresnel": "CONDUCTOR", "conserve_energy": False, "orientation": "RADIAL"},
    ],
)
def test_same_picture_as_osl(blender, tmp_path, settings):
    sphere = two_suns(tmp_path, suns=SUNS[:1])
    sphere.scale = (1.0, 0.8, 0.9)
    materials.diffracting(sphere, tmp_path / "t.exr", environment=0, **settings)
    by_osl = scenes.render(64)
    blender.context.scene.cycles.shading_system = False
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", environment=0, **settings)
    by_nodes = scenes.render(64)
    assert visible(by_osl).sum() > 500
    assert_images_agree(by_nodes, by_osl, 0.01, where=visible(by_osl), name="nodes")


def test_same_mean_for_several_lamps_as_osl(blender, tmp_path):
    """Cycles picks one lamp a sample, so that pictures of several agree in the mean only."""
    sphere = two_suns(tmp_path)
    materials.diffracting(sphere, tmp_path / "t.exr", environment=0)
    by_osl = scenes.render(64, samples=64)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", environment=0)
    by_nodes = scenes.render(64, samples=64)
    assert by_nodes.mean((0, 1)) == pytest.approx(by_osl.mean((0, 1)), rel=0.01)


def test_pigment_survives_the_change_of_implementation(blender, tmp_path):
    sphere = two_suns(tmp_path, segments=32, rings=16)
    made = materials.diffracting(sphere, tmp_path / "t.exr", pigment=(0.2, 0.3, 0.4, 1))
    from diffraction_shader.addon import lights, material

    for implementation in ("NODES", "OSL", "NODES"):
        settings = material.Settings(implementation=implementation)
        material.apply(made, tmp_path / "t.exr", settings, lights.lamp_objects(bpy.context.scene))
        node = material.shader_node(made)
        assert node.inputs["Base"].links[0].from_node.name == "Pigment"
        assert material.settings_of(made).implementation == implementation
        outputs = [n.target for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial"]
        assert sorted(outputs) == (["CYCLES", "EEVEE"] if implementation == "NODES" else ["ALL"])


def test_file_is_packed_and_needs_nothing_else(blender, tmp_path):
    sphere = two_suns(tmp_path, segments=64, rings=32)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES")
    before = scenes.render(24)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    for name in ("t.exr", "t.json"):
        (tmp_path / name).unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert np.array_equal(scenes.render(24), before)


def test_nodes_follow_new_lamps(blender, tmp_path):
    sphere = two_suns(tmp_path, suns=[], segments=64, rings=32)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", fresnel="NONE")
    assert scenes.render(16).max() == 0.0
    scenes.add_sun((0.1, 0.2, 1.0))
    bpy.context.view_layer.update()
    bpy.context.view_layer.update()
    assert scenes.render(16).max() > 0.1


@pytest.mark.slow
def test_eevee_is_close_to_cycles_for_a_sun(blender, tmp_path):
    """On a faceted ball, so that EEVEE's own place of its samples within a pixel does not matter."""
    ball = two_suns(tmp_path, suns=SUNS[:1], segments=16, rings=8)
    ball.data.shade_flat()
    materials.diffracting(ball, tmp_path / "t.exr", implementation="NODES", fresnel="NONE")
    scene = blender.context.scene
    by_cycles = scenes.render(96)
    scene.render.engine = "BLENDER_EEVEE"
    scene.eevee.taa_render_samples = 8
    scene.eevee.use_raytracing = scene.eevee.use_shadows = False
    by_eevee = scenes.render(96)
    shifted = [np.roll(by_cycles, (i, j), (0, 1)) for i in range(-2, 3) for j in range(-2, 3)]
    even = (np.ptp(shifted, axis=0).max(-1) < 0.02 * by_cycles.max(-1)) & (by_cycles.max(-1) > 0.02)
    assert even.sum() > 300
    assert len(np.unique(by_cycles[even].round(2), axis=0)) > 20  # many facets, many colours
    assert_images_agree(by_eevee, by_cycles, 0.03, where=even, name="eevee")
