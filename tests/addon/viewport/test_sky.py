# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of the surroundings: their layout on the sphere, and the light that they send by way of the diffraction."""

import bpy
import numpy as np
import pytest

from precompute.light.colour import luminance_row
from tests.support.blender import drawing, extension, materials, scenes, tables
from tests.support.blender.worlds import spotted_sky


def surround(rgb, rotation=(0.0, 0.0, 0.0), strength=1.0):
    """A world with the picture; returns its Mapping node."""
    image = bpy.data.images.new("sky", rgb.shape[1], rgb.shape[0], float_buffer=True)
    image.pixels.foreach_set(np.concatenate([rgb, np.ones_like(rgb[..., :1])], -1).ravel())
    image.pack()
    world = bpy.data.worlds.new("world")
    extension.give_nodes(world)
    nodes, links = world.node_tree.nodes, world.node_tree.links
    place, mapping, picture_node = (nodes.new(f"ShaderNode{n}") for n in ("TexCoord", "Mapping", "TexEnvironment"))
    mapping.inputs["Rotation"].default_value = rotation
    picture_node.image = image
    links.new(place.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs[0], picture_node.inputs["Vector"])
    links.new(picture_node.outputs[0], nodes["Background"].inputs["Color"])
    nodes["Background"].inputs["Strength"].default_value = strength
    bpy.context.scene.world = world
    return mapping


def test_the_square_holds_the_sphere(blender):
    """Equal areas, every direction once, and sides that continue one another."""
    from diffraction_shader.addon.viewport.data import sky

    places = sky.square_directions(64)
    assert np.linalg.norm(places, axis=-1) == pytest.approx(np.ones((64, 64)), abs=1e-6)
    assert places.mean((0, 1)) == pytest.approx(np.zeros(3), abs=1e-6)
    assert (places**2).mean((0, 1)) == pytest.approx(np.full(3, 1 / 3), abs=1e-3)
    bordered = sky._bordered(places.astype(np.float32))
    for side, inside in ((bordered[0], bordered[1]), (bordered[:, -1], bordered[:, -2])):
        assert np.linalg.norm(side - inside, axis=-1).max() < 0.15  # as near as any neighbours


def test_levels_keep_the_light(blender):
    from diffraction_shader.addon.viewport.data import sky

    rgb = spotted_sky()
    lat = (np.arange(64) + 0.5) / 64 * np.pi
    mean = (rgb * np.sin(lat)[:, None, None]).sum((0, 1)) / (np.sin(lat).sum() * 128)
    squares = sky.levels(rgb)
    assert [len(square) for square in squares] == [512 >> k for k in range(len(squares))]
    for square in squares:
        assert square.mean((0, 1)) == pytest.approx(mean, rel=5e-3)


def test_what_a_diffuse_surface_sees(blender):
    """A sky of 0.4 + 0.3 z sends 0.4 + 0.2 n_z on: its first band is convolved to two thirds."""
    from diffraction_shader.addon.viewport.data import sky

    z = np.sin((np.arange(64) + 0.5) / 64 * np.pi - 0.5 * np.pi)
    rgb = np.broadcast_to((0.4 + 0.3 * z)[:, None, None], (64, 128, 3)).astype(np.float32)
    found = sky.diffuse(sky.levels(rgb))
    towards = sky.square_directions(len(found))
    assert found[..., 0] == pytest.approx(0.4 + 0.2 * towards[..., 2], abs=2e-3)
    levels = [sky.atlas_size()[0] - 258 + 2 + len(square) for square in sky.levels(rgb)[2:3]]
    assert sky.DIFFUSE_CORNER[0] >= levels[0]  # beside the third level, not over it


def sphere_under(tmp_path, rotation):
    ob = scenes.add_sphere(segments=64, rings=32)
    scenes.add_camera((0.4, -1, 0.5))
    tables.make_table(tmp_path / "t.exr", tables.gentle)
    materials.diffracting(ob, tmp_path / "t.exr", fresnel="NONE", environment=4)
    return surround(spotted_sky(), rotation)


def middle(size):
    """Pixels well inside the sphere's rim."""
    y, x = np.mgrid[0:size, 0:size] + 0.5 - size / 2
    return np.hypot(x, y) < 0.8 * size / 2.2


@pytest.mark.parametrize(("points", "bound"), [(1, 0.06), (4, 0.05), (16, 0.03)])
def test_more_directions_come_closer_to_many(renderer, tmp_path, monkeypatch, points, bound):
    """8, 16 and 32 directions against 1024 of the same kind, which leave nothing to filter."""
    from diffraction_shader.addon.viewport import drawing as viewport_drawing

    sphere_under(tmp_path, (0.3, 0.2, 0.9))
    inside = middle(48)
    few = drawing.alone(renderer, 48, points=points)[inside]
    monkeypatch.setitem(viewport_drawing.SKY_POINTS, points, 1024)
    many = drawing.alone(renderer, 48, points=points)[inside]
    assert few.mean() == pytest.approx(many.mean(), rel=bound)


@pytest.mark.slow
def test_as_cycles_without_shadows(renderer, tmp_path):
    """Mean within 3 %, mean Delta E 2000 of at most 3, the noise of Cycles included."""
    import colour

    sphere_under(tmp_path, (0.3, 0.2, 0.9))
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    scene.render.film_transparent = True
    scene.cycles.sample_clamp_indirect = 0.0
    size = 32
    inside = middle(size)
    reference = scenes.render(size, samples=1500)[inside]
    drawn = drawing.alone(renderer, size, points=16)[inside]
    assert drawn.mean(0) == pytest.approx(reference.mean(0), rel=0.03)

    def lab(rgb):
        return colour.XYZ_to_Lab(colour.RGB_to_XYZ(np.clip(rgb, 0.0, 1.0), "sRGB", apply_cctf_decoding=False))

    assert colour.delta_E(lab(reference), lab(drawn), method="CIE 2000").mean() <= 3.0


def test_the_mapping_turns_the_image(renderer, tmp_path):
    """Turned by half a turn about z, with the camera and the sphere turned the other way, nothing changes."""
    from mathutils import Matrix

    mapping = sphere_under(tmp_path, (0.0, 0.0, 0.0))
    first = drawing.alone(renderer, 32)
    mapping.inputs["Rotation"].default_value[2] = 1.1
    turn = Matrix.Rotation(-1.1, 4, "Z")
    for ob in bpy.context.scene.objects:
        ob.matrix_world = turn @ ob.matrix_world
    assert drawing.alone(renderer, 32)[middle(32)] == pytest.approx(first[middle(32)], rel=0.02, abs=2e-3)
    mapping.inputs["Rotation"].default_value[2] = 0.0
    assert not np.allclose(drawing.alone(renderer, 32), first, rtol=0.2)


def test_strength_and_a_plain_image(renderer, tmp_path):
    """An image of one colour gives what a world of that colour gives, and twice the strength twice that."""
    mapping = sphere_under(tmp_path, (0.0, 0.0, 0.0))
    assert mapping is not None
    surround(np.full((16, 32, 3), 0.5, np.float32))
    once = drawing.alone(renderer, 32, points=16)[middle(32)]
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 2.0
    assert drawing.alone(renderer, 32, points=16)[middle(32)] == pytest.approx(2 * once, rel=1e-3)


def test_what_surrounds_a_view(blender, tmp_path):
    """Material Preview's studio light with its turn and strength, the world where that is chosen, lamps on and off."""
    from diffraction_shader.addon.viewport import offscreen, surroundings

    surround(spotted_sky(), strength=3.0)
    scene = bpy.context.scene
    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        shading = override["space_data"].shading
        shading.type = "MATERIAL"
        shading.use_scene_world = shading.use_scene_lights = False
        shading.studiolight_rotate_z, shading.studiolight_intensity = 0.5, 2.0
        studio = surroundings.of_shading(scene, shading)
        assert not studio.lamps and studio.sky.path.endswith(".exr")
        assert studio.sky.strength == (2.0, 2.0, 2.0)
        turn = np.reshape(studio.sky.turn, (3, 3))
        assert turn[0, 0] == pytest.approx(np.cos(0.5)) and turn[1, 0] == pytest.approx(np.sin(0.5))
        shading.use_scene_world = shading.use_scene_lights = True
        world = surroundings.of_shading(scene, shading)
        assert world.lamps and world.sky.image == "sky" and world.sky.strength == (3.0, 3.0, 3.0)
        shading.type = "SOLID"
        assert surroundings.of_shading(scene, shading) == surroundings.of_world(scene.world)
    scene.world.node_tree.links.clear()
    output = scene.world.node_tree.get_output_node("ALL")
    background = scene.world.node_tree.nodes["Background"]
    scene.world.node_tree.links.new(background.outputs[0], output.inputs["Surface"])
    gradient = scene.world.node_tree.nodes.new("ShaderNodeTexGradient")
    scene.world.node_tree.links.new(gradient.outputs[0], background.inputs["Color"])
    found = surroundings.of_world(scene.world)
    assert found.sky.world == "world"  # rendered all around by a second Blender


def test_drawings_of_a_picture_share_the_directions(renderer, tmp_path):
    """Each drawing of a picture moves its directions: their mean is nearer to many directions than any of them."""
    from diffraction_shader.addon.viewport import drawing as viewport_drawing

    sphere_under(tmp_path, (0.3, 0.2, 0.9))
    inside = middle(32)
    moves = [(0.0, 0.0), (0.755, 0.57), (0.51, 0.14), (0.265, 0.71)]
    drawn = [drawing.alone(renderer, 32, points=1, moved=moved)[inside] for moved in moves]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(viewport_drawing.SKY_POINTS, 1, 512)
        many = drawing.alone(renderer, 32, points=1)[inside]
    errors = [np.abs(each - many).mean() for each in drawn]
    assert np.abs(np.mean(drawn, 0) - many).mean() < 0.8 * np.mean(errors)  # the rest is the blur of the sky


def test_a_window_waits_for_no_sky(blender):
    """Of what takes long nothing is done in the window's thread; an image that holds nothing is asked for once."""
    import threading
    import time

    from diffraction_shader.addon.gpu_context import ensure_gpu
    from diffraction_shader.addon.viewport.data import sky

    ensure_gpu()
    where, asked = [], []
    real = sky.levels

    def levels(pixels):
        where.append(threading.current_thread())
        return real(pixels)

    def read(one):
        asked.append(one)
        return None if one.path == "empty" else (np.ones((8, 16, 3), np.float32), np.zeros((0, 7), np.float32))

    skies = sky.Skies(read)
    flat = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sky, "levels", levels)
        for path in ("full", "empty"):
            one = sky.Sky("", path, (1,), flat, (1.0, 1.0, 1.0))
            assert skies.get(one) is None
            deadline = time.monotonic() + 60.0
            while skies._make_soon(one) is not None and time.monotonic() < deadline:
                time.sleep(0.01)
            assert (skies.get(one) is None) is (path == "empty")
    assert len(asked) == 2 and len(where) == 1 and where[0] is not threading.main_thread()


def test_a_scaled_surface_under_an_even_sky(renderer, tmp_path):
    """What it sends on is its albedo, of whatever scale and depth, and with the usual few directions."""
    from precompute.bake import bake
    from precompute.evaluate.scaled import ScaledTable
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset
    from tests.truth import radiance
    from tests.truth.hemisphere import direction, hemisphere

    path = tmp_path / "t.exr"
    table = bake(make_preset("foil", 16e-6, 200), BakeParameters(sigma_s_m=1.2e-6, detail=0.5, level="none"))
    table.save(path)
    plane, wr = scenes.add_plane(half=1.0), direction(25, 40)
    scenes.add_camera(wr, extent=0.2)
    made = materials.diffracting(plane, path, fresnel="NONE", environment=4)
    surround(np.ones((32, 64, 3), np.float32))
    wi, cell = hemisphere(400)
    for scale, depth in ((1.0, 1.0), (0.7, 0.9), (0.6, 0.4), (1.0, 0.3)):
        node = made.node_tree.nodes["Diffraction"]
        node.inputs["Scale"].default_value, node.inputs["Depth"].default_value = scale, depth
        drawn = drawing.alone(renderer, 8, points=16)[..., :3].mean((0, 1))
        xyz = (radiance.f_cos_xyz(ScaledTable(table, scale, depth), wi, wr) * cell[..., None]).sum((0, 1))
        assert drawn @ luminance_row() == pytest.approx(xyz[1], rel=0.1)
