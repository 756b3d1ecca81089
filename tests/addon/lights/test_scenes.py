# SPDX-License-Identifier: GPL-3.0-or-later
"""Other people's scenes: whichever scene is rendered, its own lights count, whatever file the material came from."""

import bpy
import numpy as np
import pytest
from mathutils import Vector

from tests.support.blender import light_list, materials, scenes, tables
from tests.support.blender.lamps import add_lamp

SUN_A, SUN_B = (0.3, -0.4, 0.8), (-0.6, 0.5, 0.7)
BOTH = pytest.mark.parametrize("implementation", ["OSL", "NODES"])


def set_up(tmp_path, implementation="OSL"):
    """A sphere before a camera, with a material of ours and no lamp."""
    if not (tmp_path / "t.exr").exists():
        tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere = scenes.add_sphere(segments=96, rings=48)
    scenes.add_camera()
    materials.diffracting(sphere, tmp_path / "t.exr", implementation=implementation, fresnel="NONE", environment=0)
    return sphere


def add_sun(scene, direction, name):
    """A sun in a scene of one's choice."""
    lamp = scenes.add_sun(direction, name=name)
    if scene != bpy.context.scene:
        bpy.context.scene.collection.objects.unlink(lamp)
        scene.collection.objects.link(lamp)
    return lamp


def shot(scene=None):
    """Mean colour of a scene's picture."""
    return scenes.render(24, samples=4, scene=scene, centred=True).mean((0, 1))


def second_scene(first):
    """Another scene with the same objects but the lamps."""
    second = bpy.data.scenes.new("B")
    second.render.engine, second.cycles.shading_system = "CYCLES", True
    for ob in first.objects:
        if ob.type != "LIGHT":
            second.collection.objects.link(ob)
    second.camera = first.camera
    return second


def render_of(scene):
    """Mean colour of another scene's picture."""
    window = bpy.context.window
    before, window.scene = window.scene, scene
    try:
        return shot()
    finally:
        window.scene = before


@BOTH
def test_each_scene_has_its_own_lights(blender, tmp_path, implementation):
    """A, B, A, and A opened fresh, against each sun alone in a scene that was always alone."""
    set_up(tmp_path, implementation)
    first = bpy.context.scene
    lamp = add_sun(first, SUN_A, "sun A")
    alone = shot()
    lamp.rotation_quaternion = Vector(SUN_B).to_track_quat("Z", "Y")
    control = shot()
    lamp.rotation_quaternion = Vector(SUN_A).to_track_quat("Z", "Y")
    second = second_scene(first)
    add_sun(second, SUN_B, "sun B")
    assert alone.max() > 0.01 and abs(alone - control).max() > 0.01 * alone.max()
    found = [render_of(scene) for scene in (first, second, first)]
    assert found[0] == pytest.approx(alone, rel=1e-3)
    assert found[1] == pytest.approx(control, rel=1e-3)
    assert found[2] == pytest.approx(alone, rel=1e-3)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "two.blend"))
    assert shot() == pytest.approx(alone, rel=1e-3)


def test_a_copied_scene_follows_its_own_lamps(blender, tmp_path):
    set_up(tmp_path)
    lamp = add_sun(bpy.context.scene, SUN_A, "sun")
    bpy.context.view_layer.update()
    bpy.ops.scene.new(type="FULL_COPY")
    copy = bpy.context.scene
    targets = {v.targets[0].id for curve in copy.animation_data.drivers for v in curve.driver.variables}
    assert lamp not in targets
    own = next(ob for ob in copy.objects if ob.type == "LIGHT")
    own.rotation_quaternion = Vector(SUN_B).to_track_quat("Z", "Y")
    assert light_list.place(1, copy) == pytest.approx(Vector(SUN_B).normalized(), abs=1e-5)


@BOTH
def test_set_scene_lights_too(blender, tmp_path, implementation):
    set_up(tmp_path, implementation)
    first = bpy.context.scene
    lamp = add_sun(first, SUN_A, "sun")
    alone = shot()
    stage = bpy.data.scenes.new("stage")
    first.collection.objects.unlink(lamp)
    stage.collection.objects.link(lamp)
    assert shot().max() < 1e-6
    first.background_set = stage
    assert shot() == pytest.approx(alone, rel=1e-3)


@pytest.mark.parametrize("how", ["append", "link", "override"])
def test_a_character_of_another_file_takes_the_light_of_the_shot(blender, tmp_path, how):
    sphere = set_up(tmp_path)
    character = bpy.data.collections.new("character")
    bpy.context.scene.collection.children.link(character)
    character.objects.link(sphere)
    bpy.context.scene.collection.objects.unlink(sphere)
    lamp = add_sun(bpy.context.scene, SUN_B, "control")
    control = shot()
    bpy.data.objects.remove(lamp)
    add_sun(bpy.context.scene, SUN_A, "sun of the library")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    scenes.add_camera()
    add_sun(scene, SUN_B, "sun of the shot")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "shot.blend"))
    folder = str(tmp_path / "library.blend/Collection/")
    getattr(bpy.ops.wm, "append" if how == "append" else "link")(directory=folder, filename="character")
    if how == "override":
        instance = next(ob for ob in scene.objects if ob.instance_type == "COLLECTION")
        bpy.context.view_layer.objects.active = instance
        instance.select_set(True)
        assert bpy.ops.object.make_override_library() == {"FINISHED"}
    assert [ob.name for ob in bpy.data.objects if ob.type == "LIGHT"] == ["sun of the shot"]
    assert control.max() > 0.01
    assert shot() == pytest.approx(control, rel=1e-3)


def test_without_a_list_the_pigment_alone_shows(blender, tmp_path):
    """Also with the add-on gone: nothing of ours runs, and what was saved renders."""
    sphere = set_up(tmp_path)
    add_sun(bpy.context.scene, SUN_A, "sun")
    with_list = shot()
    from diffraction_shader.addon.lights import light_list as lists
    from diffraction_shader.addon.materials import handlers

    handlers.unregister()
    try:
        assert shot() == pytest.approx(with_list, rel=1e-6)
        lists.remove(bpy.context.scene)
        sphere.active_material.node_tree.nodes["Diffraction"].inputs["Fresnel"].default_value = 1
        sphere.active_material.node_tree.nodes["Pigment"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
        pigment = shot()
        assert pigment.max() > 0.01 and pigment.max() == pytest.approx(pigment.min(), rel=1e-3)
    finally:
        handlers.register()


def test_lamp_of_geometry_nodes(blender, tmp_path):
    """A spot that geometry nodes put on a point: as the lamp itself, also where the point moves."""
    set_up(tmp_path)
    spot = add_lamp("SPOT", (1.0, -1.0, 2.5), energy=300.0, spot_size=2.0, shadow_soft_size=0.02)
    bpy.context.view_layer.update()
    alone, rotation = shot(), tuple(spot.rotation_euler)
    spot.location, spot.rotation_euler = (0, 0, 0), (0, 0, 0)
    bpy.context.scene.collection.objects.unlink(spot)
    bpy.data.collections.new("hidden").objects.link(spot)
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(1.0, -1.0, 2.5)], [], [])
    rig = bpy.data.objects.new("rig", mesh)
    bpy.context.scene.collection.objects.link(rig)
    rig.modifiers.new("nodes", "NODES").node_group = instancing(spot, rotation)
    assert shot() == pytest.approx(alone, rel=0.01)
    rig.location = (100.0, 0.0, 0.0)
    assert shot().max() < 0.01 * alone.max()


def test_lamps_of_instances_are_keyed_for_farms(blender, tmp_path):
    """Frame by frame as with the extension, which is gone then; a second bake and Clear leave nothing behind."""
    set_up(tmp_path)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 3
    spot = add_lamp("SPOT", (1.0, -1.0, 2.5), energy=300.0, spot_size=2.5, shadow_soft_size=0.02)
    rotation = tuple(spot.rotation_euler)
    spot.location, spot.rotation_euler = (0, 0, 0), (0, 0, 0)
    scene.collection.objects.unlink(spot)
    bpy.data.collections.new("hidden").objects.link(spot)
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(1.0, -1.0, 2.5)], [], [])
    rig = bpy.data.objects.new("rig", mesh)
    scene.collection.objects.link(rig)
    rig.modifiers.new("nodes", "NODES").node_group = instancing(spot, rotation)
    for frame, x in ((1, 0.0), (3, -0.8)):
        rig.location.x = x
        rig.keyframe_insert("location", frame=frame)

    def frames():
        found = []
        for frame in (1, 2, 3):
            scene.frame_set(frame)
            found.append(shot())
        return np.array(found)

    from diffraction_shader.addon.lights import keyed
    from diffraction_shader.addon.materials import handlers

    with_extension = frames()
    assert np.abs(with_extension[0] - with_extension[2]).max() > 0.02 * with_extension.max()
    scene.frame_set(2)
    for _ in range(2):
        assert bpy.ops.diffraction.bake_lights() == {"FINISHED"}
    assert scene.frame_current == 2 and keyed.is_baked(scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "keyed.blend"))
    handlers.unregister()
    try:
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "keyed.blend"))
        scene = bpy.context.scene
        assert frames() == pytest.approx(with_extension, rel=0.01)
    finally:
        handlers.register()
    assert bpy.ops.diffraction.bake_lights(clear=True) == {"FINISHED"}
    assert not keyed.is_baked(scene)


def test_lamps_that_drivers_follow_need_no_keys(blender, tmp_path):
    set_up(tmp_path)
    add_sun(bpy.context.scene, SUN_A, "sun")
    bpy.context.view_layer.update()
    assert bpy.ops.diffraction.bake_lights() == {"CANCELLED"}


def instancing(ob, rotation):
    """Geometry nodes that put an object on each point."""
    tree = bpy.data.node_groups.new("instances", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    given, out, put, info = (
        tree.nodes.new(kind)
        for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeInstanceOnPoints", "GeometryNodeObjectInfo")
    )
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = ob, True
    put.inputs["Rotation"].default_value = rotation
    for a, b in ((given.outputs[0], put.inputs["Points"]), (info.outputs["Geometry"], put.inputs["Instance"]),
                 (put.outputs[0], out.inputs[0])):  # fmt: skip
        tree.links.new(a, b)
    return tree


@pytest.mark.parametrize("persistent", [False, True])
@pytest.mark.parametrize("when", ["render_pre", "frame_change_pre", "frame_change_post"])
def test_lamps_that_a_handler_switches_or_makes(blender, tmp_path, when, persistent):
    set_up(tmp_path)
    scene = bpy.context.scene
    day = add_sun(scene, SUN_A, "day")
    by_day = shot()
    day.rotation_quaternion = Vector(SUN_B).to_track_quat("Z", "Y")
    by_night = shot()
    day.rotation_quaternion = Vector(SUN_A).to_track_quat("Z", "Y")
    scene.render.use_persistent_data = persistent
    made = []

    def swap(*_):
        day.hide_render = True
        if not made:
            made.append(add_sun(scene, SUN_B, "night"))

    where = getattr(bpy.app.handlers, when)
    assert shot() == pytest.approx(by_day, rel=1e-3)
    where.append(swap)
    try:
        found = shot()
    finally:
        where.remove(swap)
    assert np.abs(by_day - by_night).max() > 0.01 * by_day.max()
    assert found == pytest.approx(by_night, rel=1e-3)


def test_seventeen_lamps_with_the_sun_last_by_name(blender, tmp_path):
    set_up(tmp_path)
    add_sun(bpy.context.scene, SUN_A, "Sun")
    alone = shot()
    for number in range(16):
        add_lamp("POINT", (50.0 + number, 50.0, 5.0), energy=0.01, name=f"Point {number}", shadow_soft_size=0.1)
    found = scenes.render(24, samples=64, centred=True).mean((0, 1))
    assert found == pytest.approx(alone, rel=0.05)  # Cycles picks one lamp a sample
    assert 1 in light_list.kinds(count=16)


def test_handlers_of_others_are_all_called(blender, tmp_path):
    """Ours go behind them without making Blender pass over one, from the first render on."""
    scenes.plane_with_table(tmp_path)
    scenes.add_camera()
    bpy.ops.diffraction.apply_material(implementation="NODES", environment=0)
    called = []

    def before(*_):
        called.append("init")

    def each(*_):
        called.append("pre")

    bpy.app.handlers.render_init.append(before)
    bpy.app.handlers.render_pre.append(each)
    try:
        for _ in range(2):
            scenes.render(4)
    finally:
        bpy.app.handlers.render_init.remove(before)
        bpy.app.handlers.render_pre.remove(each)
    assert called == ["init", "pre"] * 2
