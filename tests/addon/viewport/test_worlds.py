# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds of many nodes, and what in them and among the objects shines like a lamp."""

import subprocess

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, extension, materials, scenes, tables
from tests.support.blender.lamps import add_lamp
from tests.support.blender.worlds import picture, picture_world


@pytest.fixture
def ball(renderer, tmp_path):
    """A diffracting sphere and its camera, without light."""
    ob = scenes.add_sphere(segments=64, rings=32)
    scenes.add_camera((0.4, -1, 0.5))
    tables.make_table(tmp_path / "t.exr", tables.gentle)
    materials.diffracting(ob, tmp_path / "t.exr", fresnel="NONE", environment=4)
    return ob


def world(*kinds):
    """A world in force, without links but for its Background, and new nodes in it."""
    made = bpy.data.worlds.new("world")
    extension.give_nodes(made)
    bpy.context.scene.world = made
    return made.node_tree, *(made.node_tree.nodes.new(f"ShaderNode{kind}") for kind in kinds)


def studio_world(name):
    """A world of the picture that one of Blender's studio lights is made of."""
    tree, image = world("TexEnvironment")
    path = next(each.path for each in bpy.context.preferences.studio_lights if each.name == name)
    image.image = bpy.data.images.load(path)
    tree.links.new(image.outputs[0], tree.nodes["Background"].inputs[0])


def middle(size):
    """Pixels well inside the sphere's rim."""
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    return np.hypot(x, y) < 0.8 * size / 2.2


def test_a_world_of_many_nodes(renderer, ball, monkeypatch):
    """What the camera alone sees lights nothing; what is mixed for all other rays does, as the plain colour does."""
    from diffraction_shader.addon.viewport.data import panorama

    monkeypatch.setattr(panorama, "WIDTH", 64)
    tree, light, path, mix = world("Background", "LightPath", "MixShader")
    light.inputs["Color"].default_value = (0.2, 0.5, 0.7, 1.0)
    tree.nodes["Background"].inputs["Color"].default_value = (9.0, 0.0, 0.0, 1.0)
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(light.outputs[0], mix.inputs[1])
    tree.links.new(tree.nodes["Background"].outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])
    mixed = drawing.alone(renderer, 32, points=16)[middle(32)]
    bpy.context.scene.world = None
    picture_world(np.full((16, 32, 3), (0.2, 0.5, 0.7)))
    plain = drawing.alone(renderer, 32, points=16)[middle(32)]
    assert mixed.min() > 0.01
    assert mixed == pytest.approx(plain, rel=2e-3)


def test_a_world_is_rendered_anew_only_when_it_changed(renderer, ball, monkeypatch):
    from diffraction_shader.addon.viewport.data import panorama, sky

    tree, gradient = world("TexGradient")
    tree.links.new(gradient.outputs[0], tree.nodes["Background"].inputs["Color"])
    made = []

    class Made(panorama.Panorama):
        def __init__(self, asked):
            made.append(panorama.stamp(asked))

        def result(self):
            return np.full((8, 16, 3), float(len(made)), np.float32), np.zeros((0, 7), np.float32)

    monkeypatch.setattr(sky, "Panorama", Made)
    first = drawing.alone(renderer, 16)
    tree.nodes["Background"].location.x += 50.0
    bpy.context.scene.frame_set(3)
    assert np.array_equal(drawing.alone(renderer, 16), first)
    gradient.gradient_type = "SPHERICAL"
    assert drawing.alone(renderer, 16)[middle(16)] == pytest.approx(2.0 * first[middle(16)], rel=1e-3)
    tree.nodes["Background"].inputs["Strength"].default_value = 0.5
    drawing.alone(renderer, 16)
    assert len(made) == len(set(made)) == 3


def test_a_world_that_cannot_be_rendered_is_named_once(renderer, ball, monkeypatch):
    from diffraction_shader.addon.viewport.data import panorama

    tree, gradient = world("TexGradient")
    tree.links.new(gradient.outputs[0], tree.nodes["Background"].inputs["Color"])
    real = subprocess.Popen
    monkeypatch.setattr(
        panorama.subprocess, "Popen", lambda words, **more: real([words[0], "-c", "raise SystemExit(1)"], **more)
    )
    assert drawing.alone(renderer, 16).max() == 0.0
    assert "world" in renderer.skies.message
    bpy.context.scene.world = None
    assert drawing.alone(renderer, 16).max() > 0.0  # three lamps stand in where there is no light at all


@pytest.mark.slow
def test_a_sky_as_cycles_shows_it(renderer, ball):
    """Means within 3 %, Delta E 2000 of at most 3, and its sun where the scene's list has it."""
    import colour

    tree, sky = world("TexSky")
    sky.sun_elevation, sky.sun_rotation = 0.6, 2.6
    tree.nodes["Background"].inputs["Strength"].default_value = 0.1
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    bpy.context.view_layer.update()
    drawn = drawing.alone(renderer, 32, points=16)[middle(32)]
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    scene.render.film_transparent, scene.cycles.sample_clamp_indirect = True, 0.0
    reference = scenes.render(32, samples=256)[middle(32)]
    assert drawn.mean(0) == pytest.approx(reference.mean(0), rel=0.03)

    def lab(rgb):
        return colour.XYZ_to_Lab(colour.RGB_to_XYZ(np.clip(rgb, 0.0, 1.0), "sRGB", apply_cctf_decoding=False))

    assert colour.delta_E(lab(reference), lab(drawn), method="CIE 2000").mean() <= 3.0
    (lit,) = renderer.skies._held.values()
    listed = np.array(scene["diffraction_lamp_01"])[:3]
    assert lit.suns[0, :3] == pytest.approx(listed / np.linalg.norm(listed), abs=1e-5)


def test_a_bright_spot_shines_as_a_sun(renderer, ball):
    """An image with a small bright disc: the same as the image without it and a sun of its irradiance."""
    rgb = np.full((128, 256, 3), 0.2)
    rgb[96:98, 60:63] = (900.0, 700.0, 500.0)
    node = picture_world(rgb)
    node.id_data.nodes["Background"].inputs["Strength"].default_value = 2.0
    with_spot = drawing.alone(renderer, 32, points=16)[middle(32)]
    (lit,) = renderer.skies._held.values()
    ((x, y, z, red, green, blue, radius),) = lit.suns
    elevation = (97.0 / 128 - 0.5) * np.pi
    pixels = 6 * (np.pi / 128) * (2.0 * np.pi / 256) * np.cos(elevation)
    assert (red, green, blue) == pytest.approx(tuple(pixels * (c - 0.2) for c in (900, 700, 500)), rel=0.02)
    assert z == pytest.approx(np.sin(elevation), abs=0.01)
    assert 0.01 < radius < 0.05
    rgb[96:98, 60:63] = 0.2
    node.image = picture(rgb)
    scenes.add_sun((x, y, z), strength=2.0, angle=2.0 * float(radius), name="spot")
    bpy.data.objects["spot"].data.color = (red, green, blue)
    bpy.context.view_layer.update()
    assert drawing.alone(renderer, 32, points=16)[middle(32)] == pytest.approx(with_spot, rel=0.01)


def test_what_glows_shines_as_a_ball(renderer, ball):
    """A glowing ball of radiance L: a point lamp of the same size and L pi r^2 in every direction."""
    bulb = scenes.add_sphere("bulb", segments=64, rings=32)
    bulb.location, bulb.scale = (0.8, -1.5, 2.0), (0.1, 0.1, 0.1)
    glow = bpy.data.materials.new("glow")
    extension.give_nodes(glow)
    shader = glow.node_tree.nodes["Principled BSDF"]
    shader.inputs["Emission Color"].default_value = (1.0, 0.6, 0.2, 1.0)
    shader.inputs["Emission Strength"].default_value = 100.0
    bulb.data.materials.append(glow)
    bpy.context.view_layer.update()
    glowing = drawing.alone(renderer, 32, points=16)[middle(32)]
    bpy.data.objects.remove(bulb)
    lamp = add_lamp("POINT", (0.8, -1.5, 2.0), energy=400.0 * np.pi**2 * 0.01, shadow_soft_size=0.1)
    lamp.data.color = (1.0, 0.6, 0.2)
    by_lamp = drawing.alone(renderer, 32, points=16)[middle(32)]
    assert by_lamp.max() > 0.1
    assert glowing == pytest.approx(by_lamp, rel=0.01, abs=1e-4)


def test_instanced_lamps(renderer, ball):
    """A lamp that vertices show: the same as lamps that stand there."""
    carrier = bpy.data.objects.new("carrier", bpy.data.meshes.new("carrier"))
    carrier.data.from_pydata([(0.9, -1.5, 2.0), (-0.9, -1.5, 2.0)], [], [])
    bpy.context.scene.collection.objects.link(carrier)
    lamp = add_lamp("POINT", (0.0, 0.0, 0.0), energy=60.0)
    lamp.parent, carrier.instance_type = carrier, "VERTS"
    bpy.context.view_layer.update()
    instanced = drawing.alone(renderer, 32, points=4)[middle(32)]
    bpy.data.objects.remove(carrier)
    bpy.data.objects.remove(lamp)
    for place in ((0.9, -1.5, 2.0), (-0.9, -1.5, 2.0)):
        add_lamp("POINT", place, energy=60.0)
    plain = drawing.alone(renderer, 32, points=4)[middle(32)]
    assert plain.max() > 0.1
    assert instanced == pytest.approx(plain, rel=1e-3)


def test_of_too_many_lamps_the_brightest_are_drawn(renderer, ball):
    for number in range(16):
        add_lamp("POINT", (0.0, 5.0, 40.0), energy=1.0, name=f"A{number:02d}")
    weak = drawing.alone(renderer, 32)[middle(32)]
    add_lamp("SUN", (0.3, -1.0, 1.0), energy=3.0, name="Sun")
    assert drawing.alone(renderer, 32)[middle(32)].mean() > 100.0 * weak.mean()


def test_what_eevee_takes_out_of_an_image(blender):
    """All light above the threshold, each spot where it stands, with what is bright about it."""
    from diffraction_shader.addon.lights import hot_spots

    pixels = np.ones((64, 128, 3), np.float32)
    pixels[40, 30], pixels[40, 31] = (9000.0, 6000.0, 3000.0), (30.0, 20.0, 10.0)
    pixels[20:23, 90:93] = (25.0, 50.0, 25.0)
    spots = hot_spots.search(pixels.mean(-1))
    rest, suns = hot_spots.split(pixels, spots)
    assert len(suns) == 1
    found = hot_spots.suns_above(rest, suns, 10.0)
    assert len(found) == 2
    assert found[:, :3] @ suns[0, :3] == pytest.approx([1.0, found[1, :3] @ suns[0, :3]], abs=1e-6)
    theta = ((np.arange(64) + 0.5) / 64 - 0.5) * np.pi
    size = np.cos(theta)[:, None, None] * (np.pi / 64) * (2 * np.pi / 128)
    above = pixels * np.maximum(1.0 - 10.0 / pixels.max(-1), 0.0)[..., None] * size
    assert found[:, 3:6].sum(0) == pytest.approx(above.sum((0, 1)), rel=3e-3)
    assert found[1, 3:6] == pytest.approx(above[20:23, 90:93].sum((0, 1)), rel=1e-5)
    assert found[1, 3] == pytest.approx(0.5 * found[1, 4])  # in its colour
    assert len(hot_spots.suns_above(rest, suns, 1e9)) == 1
    none = np.zeros((0, 7), np.float32)
    assert hot_spots.suns_above(np.ones((8, 16, 3), np.float32), none, 10.0).shape == (0, 7)


def test_the_sun_that_eevee_makes_of_an_image(blender):
    """All light above the threshold from its mean direction, if it is a good part of all; 0 takes out none."""
    from diffraction_shader.addon.lights import hot_spots, worlds
    from diffraction_shader.addon.versions import EEVEE

    pixels = np.ones((64, 128, 3), np.float32)
    pixels[40, 30], pixels[20, 90] = 9000.0, 4500.0
    ((x, y, z, _, strength),) = hot_spots.mean_above(pixels, 10.0)
    lat, lon = ((np.array([40, 20]) + 0.5) / 64 - 0.5) * np.pi, ((np.array([30, 90]) + 0.5) / 128 - 0.5) * -2 * np.pi
    towards = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1)
    light = np.array([8990.0, 4490.0]) * np.cos(lat) * (np.pi / 64) * (2 * np.pi / 128)
    mean = (towards * light[:, None]).sum(0)
    assert strength == pytest.approx(light.sum(), rel=1e-5)
    assert np.array([x, y, z]) @ mean / np.linalg.norm(mean) == pytest.approx(1.0, abs=1e-5)
    assert hot_spots.mean_above(pixels, 1e4) == []
    assert hot_spots.mean_above(np.ones((8, 16, 3), np.float32), 0.9999) == []  # no part of it that counts

    node = picture_world(pixels)
    shown = bpy.context.scene.world
    assert len(list(worlds.of_world(shown))) == 2
    # Far apart from each other: each shines by itself, as strongly as the Background says.
    first, second = worlds.of_world(shown, by_eevee=True)
    assert [each.value() for each in first.entries[4:7]] == pytest.approx([light[0]] * 3, rel=1e-4)
    assert first.entries[:3] == pytest.approx(towards[0], abs=1e-5)
    assert second.entries[:3] == pytest.approx(towards[1], abs=1e-5)
    shown.node_tree.nodes["Background"].inputs["Strength"].default_value = 2.0
    assert next(worlds.of_world(shown, by_eevee=True)).entries[4].value() == pytest.approx(2.0 * light[0], rel=2e-3)
    shown.node_tree.nodes["Background"].inputs["Strength"].default_value = 1.0

    # One beside the other, or of a world that does more with the image: EEVEE's own sun.
    pixels[20, 90], pixels[41, 31] = 1.0, 4500.0
    node.image = picture(pixels)
    (sun,) = worlds.of_world(shown, by_eevee=True)
    assert sun.entries[4:7] == (0.0, 0.0, 0.0)
    bpy.context.scene.render.engine = EEVEE
    assert [each.key for each in worlds.sources(bpy.context.scene)] == [sun.key]
    shown.sun_threshold = 0.0
    assert list(worlds.of_world(shown, by_eevee=True)) == []


def test_suns_in_place_of_the_one_that_eevee_makes(blender):
    """Where its light comes from many sides: all of the light, each part in the mean direction of what is about it."""
    from diffraction_shader.addon.lights import hot_spots

    pixels = np.full((64, 128, 3), 0.5, np.float32)
    for row, column, rgb in ((40, 10, (900, 600, 300)), (20, 90, (100, 300, 200)), (50, 70, (50, 50, 90))):
        pixels[row : row + 3, column : column + 3] = rgb
    towards, light = hot_spots._above(pixels, 10.0)
    found = np.array(hot_spots.own_suns(pixels, 10.0))
    assert found.shape == (3, 7)
    assert found[:, 3:6].sum(0) == pytest.approx(light.sum(0), rel=1e-5)
    for row in found:
        near = towards @ row[:3] > 0.95
        assert light[near].sum(0) == pytest.approx(row[3:6], rel=1e-5)
    assert hot_spots.own_suns(np.where(np.arange(128)[:, None] < 30, pixels, 0.5), 10.0) == []
    grey = hot_spots.own_suns(pixels[..., :1], 10.0)
    assert [row[3] for row in grey] == [row[4] for row in grey] and len(grey) == 3


def test_an_image_of_a_library_is_searched_once(blender, tmp_path, monkeypatch):
    """It cannot keep what was found, and lights are looked for at each change of the scene."""
    from diffraction_shader.addon.lights import hot_spots

    pixels = np.ones((64, 128, 3), np.float32)
    pixels[40, 30] = 9000.0
    place = str(tmp_path / "library.blend")
    bpy.data.libraries.write(place, {picture(pixels)})
    with bpy.data.libraries.load(place, link=True) as (there, here):
        here.images = there.images
    (image,) = here.images
    assert image.library is not None
    first = hot_spots.of(image)
    monkeypatch.setattr(hot_spots, "search", lambda luminance: pytest.fail("searched again"))
    assert len(first) == 1
    assert hot_spots.of(image) == first


def sun_with_halo():
    """``(128, 256, 3)`` radiance of a small sun whose halo falls with the square of the angle, and of a dim sky."""
    lat, lon = (np.mgrid[0:128, 0:256] + 0.5) * (np.pi / 128) - [[[0.5 * np.pi]], [[0.0]]]
    place = np.stack([-np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1)
    apart = np.arccos(np.clip(place @ (np.array((0.6, -0.6, 0.5)) / np.linalg.norm((0.6, -0.6, 0.5))), -1.0, 1.0))
    light = np.where(apart < 0.03, 4e4, 4e3 * (0.03 / np.maximum(apart, 0.03)) ** 2) + 0.3
    return (light[..., None] * (1.0, 0.9, 0.8)).astype(np.float32)


def test_a_halo_is_no_sun_of_its_own(blender):
    """Two lobes about one another counted the light in both: 1.25 times the sun's. Two suns far apart stay two."""
    from diffraction_shader.addon.lights import hot_spots

    pixels = sun_with_halo()
    ((x, y, z, radius, _),) = hot_spots.search(pixels.mean(-1))
    assert np.array((x, y, z)) @ (0.6, -0.6, 0.5) == pytest.approx(np.linalg.norm((0.6, -0.6, 0.5)), abs=1e-3)
    assert radius < 0.07
    assert len(hot_spots.search((pixels + pixels[:, ::-1]).mean(-1))) == 2


@pytest.mark.slow
@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_a_sun_with_a_halo_in_cycles(renderer, ball, tmp_path, implementation):
    """As the viewport, which numpy's sums prove (test_hdri), shows it."""
    materials.diffracting(ball, tmp_path / "t.exr", implementation, fresnel="NONE", environment=4)
    picture_world(sun_with_halo())
    bpy.context.view_layer.update()
    wanted = drawing.mean_of_many(renderer, 16)[middle(16)].mean(0)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    shown = scenes.render(16, samples=128, centred=True)[middle(16)].mean(0)
    assert shown == pytest.approx(wanted, rel=0.03)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["forest", "interior", "city", "studio", "courtyard", "night"])
def test_eevee_shows_an_image_with_bright_places_as_it_is(renderer, ball, tmp_path, name):
    """As the viewport, which numpy's sums prove (test_hdri): one lamp, or several far apart.

    EEVEE lets them shine from one direction. Where no lamp was listed a world of three lamps kept a seventh; where that
    direction was, between them, a ball had 1.1 to 1.5 times its light.
    """
    from diffraction_shader.addon.versions import EEVEE

    table = tmp_path / "own.exr"
    tables.make_table(table, tables.gentle, albedo="own")
    materials.diffracting(ball, table, "NODES", fresnel="NONE")
    studio_world(f"{name}.exr")
    wanted = drawing.mean_of_many(renderer, 24)[middle(24)].mean(0)
    bpy.context.scene.render.engine = EEVEE
    shown = scenes.render(24, samples=8)[middle(24)].mean(0)
    print(f"{name}: EEVEE over the sum of all directions {(shown / wanted).round(3)}")
    assert shown == pytest.approx(wanted, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["forest.exr", "studio.exr"])
def test_material_preview_of_nodes_as_cycles_shows_the_studio_light(renderer, ball, tmp_path, name):
    """EEVEE takes a fifth of the forest's light out as a sun: 0.73 to 0.84 of the diffraction were left."""
    from diffraction_shader.addon.viewport import looks, offscreen

    table = tmp_path / "own.exr"
    tables.make_table(table, tables.gentle, albedo="own")
    materials.diffracting(ball, table, "NODES", fresnel="NONE")
    studio_world(name)
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    by_cycles = scenes.render(32, samples=256)[middle(32)].mean(0)
    scene.world = None
    bpy.context.view_layer.update()
    with offscreen.view_3d() as override:
        shading = override["space_data"].shading
        shading.type, shading.studio_light = "MATERIAL", name
        shading.use_scene_lights = shading.use_scene_world = False
        shading.studiolight_intensity = 1.0
        found = offscreen.render(renderer, scene, scene.camera, (32, 32), "MATERIAL", looks.View(points=16))
    assert found[middle(32)][..., :3].mean(0) == pytest.approx(by_cycles, rel=0.05)
