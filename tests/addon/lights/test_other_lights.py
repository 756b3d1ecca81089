# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that are no lamps: the sun of a sky, glowing meshes, bright spots of an image of the surroundings."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Vector

from tests.support.blender import extension, materials, scenes, tables


def set_up(tmp_path, **settings):
    """A sphere before a camera, with a material of ours and no lamp."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere = scenes.add_sphere(segments=96, rings=48)
    scenes.add_camera((0.0, -0.2, 1.0))
    materials.diffracting(sphere, tmp_path / "t.exr", fresnel="NONE", **settings)
    return sphere


def world():
    """A new world of the scene and its nodes."""
    made = bpy.data.worlds.new("world")
    bpy.context.scene.world = made
    return made, extension.give_nodes(made)


def sky(elevation, rotation):
    """A sky with a sun."""
    made, tree = world()
    node = tree.nodes.new("ShaderNodeTexSky")
    if node.bl_rna.properties["sky_type"].enum_items.get("NISHITA") is not None:
        node.sky_type = "NISHITA"
    node.sun_elevation, node.sun_rotation, node.sun_size = elevation, rotation, math.radians(0.545)
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs[0])
    return made, node


def shot(samples, seed=0):
    bpy.context.scene.cycles.seed = seed
    return scenes.render(16, samples=samples, centred=True).mean((0, 1))


def test_sun_of_a_sky_is_found_like_a_lamp(blender, tmp_path):
    """Its disc at 64 samples: with the sky's own light taken away, what a sun lamp of its strength gives."""
    elevation, rotation = math.radians(40), math.radians(200)
    sphere = set_up(tmp_path)
    made, node = sky(elevation, rotation)
    made.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.01
    found = np.array([shot(64, seed) for seed in (1, 2, 3)])
    node.sun_disc = False
    without = np.array([shot(64, seed) for seed in (1, 2, 3)])
    by_disc = (found - without).mean(0)
    # How strong the sun is tells a white diffuse sphere under the same light.
    white = materials.white_diffuse(sphere)
    node.sun_disc = True
    lit = shot(256)
    node.sun_disc = False
    lit = lit - shot(256)
    bpy.context.scene.world = None
    direction = (
        math.cos(elevation) * math.sin(rotation),
        math.cos(elevation) * math.cos(rotation),
        math.sin(elevation),
    )
    lamp = scenes.add_sun(direction, angle=math.radians(0.545))
    lamp.data.cycles.use_multiple_importance_sampling = True
    unit = shot(256)
    colour = lit / unit
    assert colour.max() > 0.1 and white is not None
    sphere.data.materials.clear()
    sphere.data.materials.append(bpy.data.materials["sphere"])
    controls = np.array([shot(64, seed) for seed in (1, 2, 3)]) * colour
    assert by_disc == pytest.approx(controls.mean(0), rel=0.05)
    spread = np.ptp(found.mean(-1)) / found.mean()
    assert spread < 1.2 * np.ptp(controls.mean(-1)) / controls.mean() + 0.005


def test_keys_of_a_sky_move_its_sun(blender, tmp_path):
    """In the list, by its drivers alone: a farm without the extension follows too."""
    from diffraction_shader.addon.lights import slots

    set_up(tmp_path)
    _, node = sky(0.2, 0.5)
    bpy.context.view_layer.update()
    scene, wanted = bpy.context.scene, {}
    for frame, (elevation, rotation) in {1: (0.2, 0.5), 20: (1.2, 2.0)}.items():
        node.sun_elevation, node.sun_rotation = elevation, rotation
        for path in ("sun_elevation", "sun_rotation"):
            node.keyframe_insert(path, frame=frame)
        wanted[frame] = (math.cos(elevation) * math.sin(rotation), math.cos(elevation) * math.cos(rotation))
        wanted[frame] += (math.sin(elevation),)
    bpy.context.view_layer.update()
    extension.load().unregister()
    try:
        for frame in (20, 1, 20):
            scene.frame_set(frame)
            evaluated = scene.evaluated_get(bpy.context.evaluated_depsgraph_get())
            assert list(evaluated[slots.names(1)[0]])[:3] == pytest.approx(wanted[frame], abs=1e-6)
    finally:
        extension.load().register()


def sky_in_the_list(scene, frame):
    """Direction and kind of the first lamp, and its angle, as renders find them on a frame."""
    from diffraction_shader.addon.lights import slots

    scene.frame_set(frame)
    evaluated = scene.evaluated_get(bpy.context.evaluated_depsgraph_get())
    names = slots.names(1)
    return [*evaluated[names[0]], evaluated[names[1]][3]]


def expected_sky(node):
    from diffraction_shader.addon.lights import slots

    e, r = node.sun_elevation, node.sun_rotation
    place = math.cos(e) * math.sin(r), math.cos(e) * math.cos(r), math.sin(e)
    return pytest.approx([*place, float(node.sun_disc) * slots.KINDS["SUN"], node.sun_size], abs=2e-6)


def key_everything(node):
    for frame, (elevation, rotation, disc, size) in {1: (0.2, 0.5, True, 0.01), 10: (1.2, 2.0, False, 0.03)}.items():
        node.sun_elevation, node.sun_rotation, node.sun_disc, node.sun_size = elevation, rotation, disc, size
        for path in ("sun_elevation", "sun_rotation", "sun_disc", "sun_size"):
            node.keyframe_insert(path, frame=frame)


def cycle_with_handles(node):
    """One setting of four, with handles of its own, and a modifier."""
    from diffraction_shader.addon.lights import animated

    for frame, rotation in ((1, 0.0), (6, 2.5)):
        node.sun_rotation = rotation
        node.keyframe_insert("sun_rotation", frame=frame)
    curve = animated.bags(node.id_data)[0].fcurves[0]
    for key in curve.keyframe_points:
        key.handle_left_type = key.handle_right_type = "FREE"
    curve.keyframe_points[0].handle_right = (3.0, 2.0)
    curve.modifiers.new("CYCLES").mode_after = "REPEAT_OFFSET"


def drive_by_a_property(node):
    """A rig: a driver on the node's setting that reads a keyed property."""
    scene = bpy.context.scene
    for frame, value in ((1, 0.1), (20, 1.3)):
        scene["hour"] = value
        scene.keyframe_insert('["hour"]', frame=frame)
    curve = node.driver_add("sun_elevation")
    variable = curve.driver.variables.new()
    variable.targets[0].id_type, variable.targets[0].id = "SCENE", scene
    variable.targets[0].data_path = '["hour"]'
    curve.driver.expression = f"{variable.name}*0.9"


def strips(node):
    """What strips mix no curve tells."""
    key_everything(node)
    animation = node.id_data.animation_data
    track = animation.nla_tracks.new()
    track.strips.new("sky", 3, animation.action)
    animation.action = None


@pytest.mark.parametrize("animate", [key_everything, cycle_with_handles, drive_by_a_property, strips])
def test_animated_sky_frame_by_frame_without_a_word(blender, tmp_path, capfd, animate):
    """Blender's depsgraph knows no settings of nodes: drivers that read them say so on the console, and come late."""
    set_up(tmp_path)
    _, node = sky(0.2, 0.5)
    animate(node)
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    for frame in (1, 4, 20, 9, 2, 30, 1):
        assert sky_in_the_list(scene, frame) == expected_sky(node), frame
    scene.render.image_settings.file_format = "PNG"
    scenes.render(8)
    assert "Failed to add relation" not in "".join(capfd.readouterr())


def test_a_sky_that_strips_move_is_keyed_for_farms(blender, tmp_path):
    """Python writes it on each frame; keys do without the extension, in a file opened there."""
    set_up(tmp_path)
    world_, node = sky(0.2, 0.5)
    strips(node)
    bpy.context.view_layer.update()
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 12
    assert bpy.ops.diffraction.bake_lights() == {"FINISHED"}
    path, name = str(tmp_path / "sky.blend"), world_.name
    bpy.ops.wm.save_as_mainfile(filepath=path)
    extension.load().unregister()
    try:
        bpy.ops.wm.open_mainfile(filepath=path)
        node = next(n for n in bpy.data.worlds[name].node_tree.nodes if n.bl_idname == "ShaderNodeTexSky")
        for frame in (9, 1, 12, 4):
            assert sky_in_the_list(bpy.context.scene, frame) == expected_sky(node), frame
    finally:
        extension.load().register()


def test_moved_keys_of_a_sky_are_followed(blender, tmp_path):
    from diffraction_shader.addon.lights import animated

    set_up(tmp_path)
    world_, node = sky(0.2, 0.5)
    key_everything(node)
    bpy.context.view_layer.update()
    curves = animated.bags(node.id_data)[0].fcurves
    moved = next(curve for curve in curves if curve.data_path.endswith("sun_elevation"))
    moved.keyframe_points[1].co.y = 0.7
    moved.update()
    bpy.context.view_layer.update()
    for frame in (1, 5, 10):
        assert sky_in_the_list(bpy.context.scene, frame) == expected_sky(node), frame
    assert world_ is not None


def test_edits_of_a_sky_move_its_sun_without_a_driver(blender, tmp_path, capfd):
    """Blender's depsgraph knows no settings of a world's nodes, and says so for each driver that follows one."""
    from diffraction_shader.addon.lights import slots

    set_up(tmp_path)
    _, node = sky(0.2, 0.5)
    scene = bpy.context.scene
    for elevation, rotation, disc in ((0.2, 0.5, True), (1.1, 2.5, True), (1.1, 2.5, False)):
        node.sun_elevation, node.sun_rotation, node.sun_disc = elevation, rotation, disc
        bpy.context.view_layer.update()
        place = math.cos(elevation) * math.sin(rotation), math.cos(elevation) * math.cos(rotation), math.sin(elevation)
        assert list(scene[slots.names(1)[0]]) == pytest.approx([*place, float(disc) * slots.KINDS["SUN"]], abs=1e-6)
    assert scene.animation_data is None or not len(scene.animation_data.drivers)
    assert "Failed to add relation" not in "".join(capfd.readouterr())


def test_glowing_ball_lights_like_a_lamp_of_its_size(blender, tmp_path):
    set_up(tmp_path, environment=0)
    place, radius, radiance = (0.8, -0.6, 2.6), 0.15, 60.0
    ball = scenes.add_sphere("bulb", segments=64, rings=32)
    ball.location, ball.scale = place, (radius,) * 3
    ball.visible_camera = False
    glow = bpy.data.materials.new("glow")
    tree = extension.give_nodes(glow)
    tree.nodes.clear()
    emission, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    emission.inputs["Strength"].default_value = radiance
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    ball.data.materials.append(glow)
    found = shot(512)
    bpy.data.objects.remove(ball)
    light = bpy.data.lights.new("lamp", "POINT")
    light.energy, light.shadow_soft_size, light.use_soft_falloff = radiance * 4 * math.pi**2 * radius**2, radius, False
    lamp = bpy.data.objects.new("lamp", light)
    lamp.location = place
    bpy.context.scene.collection.objects.link(lamp)
    control = shot(512)
    assert control.max() > 0.05
    assert found == pytest.approx(control, rel=0.05)


def hdri(tmp_path, direction, radius, radiance):
    """An image of the surroundings, dim but for a disc."""
    import OpenEXR

    height, width = 256, 512
    rows, columns = np.mgrid[:height, :width]
    theta = ((rows + 0.5) / height - 0.5) * math.pi
    phi = (0.5 - (columns + 0.5) / width) * 2 * math.pi
    vectors = np.stack([np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), np.sin(theta)], -1)
    inside = vectors @ (np.array(direction) / np.linalg.norm(direction)) > math.cos(radius)
    picture = np.where(inside[..., None], radiance, 0.02) * np.ones(3)
    path = tmp_path / "surroundings.exr"
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION}, {"RGB": picture[::-1].astype(np.float32)}).write(str(path))
    return bpy.data.images.load(str(path)), int(inside.sum())


def test_bright_spot_of_an_image_is_aimed_at(blender, tmp_path):
    """Found in the image, followed as a Mapping node turns it, and rendered with little noise."""
    sphere = set_up(tmp_path)
    direction, radius = np.array((0.5, -0.4, 0.9)), 0.03
    image, count = hdri(tmp_path, direction, radius, 5000.0)
    assert count > 10
    tree = world()[1]
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs[0], tree.nodes["Background"].inputs[0])
    bpy.context.view_layer.update()
    scenes.render(8)
    listed = bpy.context.scene["diffraction_lamp_01"]
    assert listed[:3] == pytest.approx(direction / np.linalg.norm(direction), abs=0.005)
    assert 0.5 * bpy.context.scene["diffraction_lamp_01_u"][3] == pytest.approx(radius, abs=0.012)
    few = np.array([shot(64, seed) for seed in (1, 2, 3)])
    many = shot(2048)
    assert few.mean(0) == pytest.approx(many, rel=0.05)
    assert np.ptp(few.mean(-1)) < 0.15 * few.mean()
    assert sphere.active_material is not None


def test_image_turned_by_a_mapping_node(blender, tmp_path):
    """A camera that looks where the list says sees the spot in its middle, whatever the Mapping node does."""
    from diffraction_shader.addon.materials import handlers

    set_up(tmp_path)
    image, _ = hdri(tmp_path, (0.5, -0.4, 0.3), 0.03, 5000.0)
    tree = world()[1]
    node, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    node.image = image
    for a, b in ((coordinates.outputs["Generated"], mapping.inputs["Vector"]), (mapping.outputs[0], node.inputs[0]),
                 (node.outputs[0], tree.nodes["Background"].inputs[0])):  # fmt: skip
        tree.links.new(a, b)
    for ob in bpy.context.scene.objects:
        ob.hide_render = ob.type == "MESH"
    camera = bpy.context.scene.camera
    camera.data.type, camera.data.angle = "PERSP", math.radians(20)
    for kind, rotation in (("POINT", (0, 0, 0.7)), ("TEXTURE", (0, 0, -1.1)), ("POINT", (0.2, -0.1, 0.5))):
        mapping.vector_type = kind
        mapping.inputs["Rotation"].default_value = rotation
        bpy.context.view_layer.update()
        handlers.update_all()
        bpy.context.view_layer.update()
        place = Vector(bpy.context.scene["diffraction_lamp_01"][:3])
        camera.matrix_world = place.to_track_quat("-Z", "Y").to_matrix().to_4x4()
        picture = scenes.render(32, samples=4).mean(-1)
        rows, columns = np.nonzero(picture > 0.5 * picture.max())
        assert picture.max() > 100 * np.median(picture)
        assert (rows.mean(), columns.mean()) == pytest.approx((15.5, 15.5), abs=1.5)
