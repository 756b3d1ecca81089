# SPDX-License-Identifier: GPL-3.0-or-later
"""The material without OSL: the same picture as the OSL one in Cycles, nearly so in EEVEE."""

import bpy
import numpy as np
import pytest

from tests.support.blender import materials, scenes, tables
from tests.support.blender.lamps import LAMPS, add_lamp
from tests.support.blender.worlds import picture_world, white_world
from tests.support.compare import assert_images_agree

SUNS = [(0.3, -0.4, 0.8), (-0.5, 0.6, 0.7)]


def two_suns(tmp_path, suns=SUNS, **mesh):
    tables.make_table(tmp_path / "t.exr", tables.lobes, albedo=tables.rising)
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
        {"fresnel": "SCHLICK", "ior": 1.7},
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


def test_same_picture_as_osl_with_the_table_of_the_snake_preset(blender, snake, tmp_path):
    sphere = two_suns(tmp_path, suns=SUNS[:1])
    _, path = snake
    materials.diffracting(sphere, path, fresnel="NONE", environment=0)
    by_osl = scenes.render(64)
    materials.diffracting(sphere, path, implementation="NODES", fresnel="NONE", environment=0)
    by_nodes = scenes.render(64)
    assert visible(by_osl).sum() > 500
    assert by_osl.max() > 100 * np.median(by_osl[visible(by_osl)])
    assert_images_agree(by_nodes, by_osl, 0.01, where=visible(by_osl), name="nodes_snake")


def test_same_mean_for_several_lamps_as_osl(blender, tmp_path):
    """Cycles picks one lamp a sample, so that pictures of several agree in the mean only."""
    sphere = two_suns(tmp_path)
    materials.diffracting(sphere, tmp_path / "t.exr", environment=0)
    by_osl = scenes.render(64, samples=64)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", environment=0)
    by_nodes = scenes.render(64, samples=64)
    assert by_nodes.mean((0, 1)) == pytest.approx(by_osl.mean((0, 1)), rel=0.01)


def constants_without_a_field(tree):
    """Inputs without a field, of a tree and of all groups within, that are linked to a constant."""
    constants = {"ShaderNodeCombineXYZ", "ShaderNodeCombineColor", "ShaderNodeRGB", "ShaderNodeValue"}
    total = 0
    for node in tree.nodes:
        if node.bl_idname == "ShaderNodeGroup":
            total += constants_without_a_field(node.node_tree)
        for socket in (each for each in node.inputs if each.hide_value and each.is_linked):
            source = socket.links[0].from_node
            total += source.bl_idname in constants and not any(each.is_linked for each in source.inputs)
    return total


def test_blender_unrolls_the_groups_without_nodes_of_its_own(blender, tmp_path):
    """It adds one for each constant that is linked to a socket without a field, and compares its name with all others:
    162 of them took three seconds before each render."""
    tables.make_table(tmp_path / "t.exr", tables.lobes, albedo=tables.rising)
    made = materials.diffracting(scenes.add_plane(), tmp_path / "t.exr", "NODES")
    assert constants_without_a_field(made.node_tree) < 10


def test_pigment_survives_the_change_of_implementation(blender, tmp_path):
    sphere = two_suns(tmp_path, segments=32, rings=16)
    made = materials.diffracting(sphere, tmp_path / "t.exr", pigment=(0.2, 0.3, 0.4, 1))
    from diffraction_shader.addon.materials import material

    for implementation in ("NODES", "OSL", "NODES"):
        settings = material.Settings(implementation=implementation)
        material.apply(made, tmp_path / "t.exr", settings)
        node = material.shader_node(made)
        assert node.inputs["Base"].links[0].from_node.name == "Pigment"
        assert material.settings_of(made).implementation == implementation
        outputs = [n.target for n in made.node_tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial"]
        assert outputs == (["CYCLES", "EEVEE"] if implementation == "NODES" else ["ALL"])


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


def by_eevee(size, shadows=False):
    """The scene as EEVEE shows it, sampled in the middle of each pixel as `scenes.render(centred=True)` does."""
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_EEVEE"
    scene.eevee.taa_render_samples = 16 if shadows else 1
    scene.eevee.use_shadows = shadows
    scene.eevee.light_threshold = 1e-5  # beyond it EEVEE fades lamps out, on every material
    image = scenes.render(size, centred=True)
    scene.render.engine = "CYCLES"
    return image


def clear_of_horizons(size, lamp):
    """Pixels of the sphere that viewer and lamp see from more than five degrees above the surface."""
    hit, points, _, _, n = scenes.sphere_frames(bpy.data.objects["sphere"], size)
    matrix = np.array(lamp.matrix_world)
    to = matrix[:3, 2] if lamp.data.type == "SUN" else matrix[:3, 3] - points
    cos_i = (n * to).sum(-1) / np.linalg.norm(to, axis=-1)
    return hit & ((n * -scenes.camera_rays(size)[1]).sum(-1) > 0.1) & (cos_i > 0.1)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_eevee_counts_no_shader_twice(blender, tmp_path, implementation):
    """EEVEE counts a shader twice whose colour feeds a Mix Shader itself: between the two stands a number's node."""
    sphere = two_suns(tmp_path, segments=16, rings=8)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation=implementation)
    trees = [group for group in bpy.data.node_groups if group.bl_idname == "ShaderNodeTree"]
    links = [link for tree in trees for link in tree.links if link.from_node.bl_idname == "ShaderNodeShaderToRGB"]
    assert links
    assert not [link for link in links if link.to_node.bl_idname == "ShaderNodeMixShader"]


@pytest.mark.slow
def test_eevee_shows_the_world_as_cycles_does(blender, tmp_path):
    """A picture of the sky with soft colours, and its turn: means of a plane within 5 %."""
    plane = scenes.add_plane(half=1.0)
    scenes.add_camera((0.5, 0.3, 1.0), extent=0.5)
    tables.make_table(tmp_path / "t.exr", lambda u, v, w: 0.3 * tables.lobes(u, v, w))
    y, x = np.mgrid[0:64, 0:128]
    lon, lat = x / 128 * 2 * np.pi, (y / 64 - 0.5) * np.pi
    rgb = np.stack([0.4 + 0.3 * np.sin(lon), 0.3 + 0.2 * np.sin(lat), 0.4 - 0.3 * np.cos(lon)], -1)
    picture_world(rgb)
    materials.diffracting(plane, tmp_path / "t.exr", implementation="NODES", fresnel="NONE")
    by_cycles = scenes.render(16, samples=256).mean((0, 1))
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_EEVEE"
    scene.eevee.taa_render_samples = 64
    assert scenes.render(16).mean((0, 1)) == pytest.approx(by_cycles, rel=0.05)


@pytest.mark.slow
def test_eevee_equals_cycles_for_a_sun(blender, tmp_path):
    """Each pixel of a smooth sphere, from the rim to the terminator, dim colours and bright ones."""
    sphere = two_suns(tmp_path, suns=SUNS[:1])
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", fresnel="NONE", brightness=10.0)
    by_cycles = scenes.render(64, centred=True)
    seen = by_cycles.max(-1) > 0.01
    assert seen.sum() > 2000
    assert by_cycles.max() > 12.0  # brighter than a colour in EEVEE's buffers may be
    assert_images_agree(by_eevee(64), by_cycles, 0.03, where=seen, name="eevee")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["point", "ball", "spot", "square", "disk"])
def test_eevee_equals_cycles_for_a_lamp(blender, tmp_path, name):
    """f at the lamp's middle in both; of wide lamps the mean, since Cycles draws points of them at random."""
    kind, data = LAMPS[name]
    sphere = two_suns(tmp_path, suns=[])
    lamp = add_lamp(kind, (1.6, -1.2, 2.6), **data)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", fresnel="NONE")
    by_cycles = scenes.render(32, samples=64, centred=True)
    where = clear_of_horizons(32, lamp) & (by_cycles.max(-1) > 0.01)
    assert where.sum() > 300
    assert by_eevee(32)[where].mean(0) == pytest.approx(by_cycles[where].mean(0), rel=0.03)


@pytest.mark.slow
def test_a_wide_lamp_leaves_no_dark_ring_in_eevee(blender, tmp_path):
    """A mirror shows a white world beside the image of a lamp that hardly shines, though its lobe is much wider."""
    from precompute.bake import bake
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    bake(make_preset("flat", 16e-6, 180), BakeParameters(sigma_s_m=2e-6, detail=0.5)).save(tmp_path / "t.exr")
    sphere = scenes.add_sphere(segments=128, rings=64)
    scenes.add_camera((0.0, 0.0, 1.0))
    white_world()
    place = np.array((1.6, -1.2, 2.6))
    lamp = add_lamp("AREA", tuple(place), energy=1e-6, shape="SQUARE", size=0.6)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", fresnel="NONE")
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_EEVEE"
    scene.eevee.taa_render_samples = 12
    found = []
    for strength in (1e-6, 0.0):
        lamp.hide_render = strength == 0.0
        bpy.context.view_layer.update()
        found.append(scenes.render(32)[..., 1])
    hit, points, _, _, n = scenes.sphere_frames(sphere, 32)
    to_lamp = place - points
    to_lamp /= np.linalg.norm(to_lamp, axis=-1, keepdims=True)
    mirrored = 2.0 * n[..., 2:] * n - np.array((0.0, 0.0, 1.0))
    away = np.arccos(np.clip((mirrored * to_lamp).sum(-1), -1.0, 1.0))
    ring = hit & (away > 0.25) & (away < 0.4) & (n[..., 2] > 0.5)
    assert ring.sum() > 10
    with_lamp, without = found
    assert np.percentile(with_lamp[ring] / without[ring], 10) > 0.75


@pytest.mark.slow
def test_eevee_takes_four_suns_apart(blender, tmp_path):
    """As many as it reads, 25 degrees and more from one another; those of ten degrees see 4 percent of each other."""
    suns = [(0.1, 0.1, 1), (-0.5, 0.2, 0.9), (0.4, -0.6, 0.7), (0.4, 0.5, 0.8)]
    sphere = two_suns(tmp_path, suns=suns)
    materials.diffracting(sphere, tmp_path / "t.exr", implementation="NODES", fresnel="NONE")
    by_cycles = scenes.render(32, samples=256, centred=True)
    where = by_cycles.max(-1) > 0.01
    for lamp in [ob for ob in bpy.data.objects if ob.type == "LIGHT"]:
        where &= clear_of_horizons(32, lamp) | (np.array(lamp.matrix_world)[2, 2] < 0.6)
    assert where.sum() > 200
    ratio = by_eevee(32)[where].sum(-1) / by_cycles[where].sum(-1)
    assert ratio.mean() == pytest.approx(1.0, abs=0.01)
    assert np.percentile(np.abs(ratio - 1.0), 75) < 0.03  # Cycles picks one lamp a sample


@pytest.mark.slow
def test_eevee_casts_shadows_and_the_world_hardly_shines_through_the_lobes(blender, tmp_path):
    """A blocker's shadow on a plane: its edge where Cycles has it; with no mirrors the world adds little."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane, blocker = scenes.add_plane(half=2.0), scenes.add_plane("blocker", half=0.4)
    blocker.location = (0.2, 0.1, 0.6)
    blocker.visible_camera = False
    scenes.add_sun((0.5, 0.2, 0.9), strength=3.0)
    scenes.add_camera((0.3, 0.0, 1.0), extent=2.0)
    materials.diffracting(plane, tmp_path / "t.exr", implementation="NODES", fresnel="NONE", environment=0)
    black = bpy.data.materials.new("black")
    black.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0, 0, 0, 1)
    black.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = 0.0
    blocker.data.materials.append(black)
    bpy.context.scene.cycles.max_bounces = 0
    by_cycles, found = scenes.render(48, centred=True)[..., 1], by_eevee(48, shadows=True)[..., 1]
    dark = by_cycles < 0.01 * by_cycles.max()
    assert 50 < dark.sum() < 1000
    assert ((found < 0.1 * found.max()) == dark).mean() > 0.97  # but for the pixels of the edge
    lit = by_cycles > 0.1 * by_cycles.max()
    assert np.median(found[lit] / by_cycles[lit]) == pytest.approx(1.0, abs=0.03)
    white_world()
    with_world = by_eevee(48, shadows=True)[..., 1]
    assert np.median((with_world - found)[lit] / found[lit]) < 0.02
