# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport follows the scene: occlusion, instances, moves, modifiers, undo, files, switches."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.support.blender import drawing, scenes, tables
from tests.support.blender import viewport_scene as scene


@pytest.fixture
def sphere(renderer, tmp_path):
    """A sphere of ours under a sun before a camera."""
    tables.make_table(tmp_path / "table.exr", tables.lobes)
    ob = scenes.add_sphere(segments=32, rings=16)
    scenes.add_sun((0.3, 0.2, 1), strength=2)
    scenes.add_camera(extent=4.4).matrix_world = Matrix.Translation((0, 0, 10))
    scene.give_material(ob, tmp_path / "table.exr", fresnel="NONE")
    return ob


def lit(image):
    """Where diffraction was drawn, as a mask."""
    return image.sum(-1) > 1e-6


def box(mask):
    """Extent of a mask: left, right, bottom, top as fractions of its size."""
    rows, columns = np.nonzero(mask.any(1))[0], np.nonzero(mask.any(0))[0]
    size = mask.shape[0]
    return np.array([columns[0], columns[-1] + 1, rows[0], rows[-1] + 1]) / size


def test_an_object_in_front_hides_and_one_behind_does_not(renderer, sphere):
    wall = scenes.add_plane("wall", half=5.0)
    wall.location = (5.0, 0.0, 2.0)  # over the right half, above the sphere
    before = drawing.over_scene(renderer)
    light = before - _without(renderer)
    size = light.shape[0]
    near, far = int(0.4 * size), int(0.6 * size)
    assert (light[near:far, near : size // 2 - 2].sum(-1) > 1e-4).all()
    assert np.abs(light[:, size // 2 + 2 :]).max() < 1e-6
    wall.location.z = -2.0
    light = drawing.over_scene(renderer) - _without(renderer)
    assert (light[near:far, size // 2 + 2 : far].sum(-1) > 1e-4).all()


def _without(renderer):
    """The same picture without diffraction."""
    return drawing.over_scene(renderer, brightness=0.0)


def test_no_depth_fighting_where_the_scene_was_drawn_before(renderer, sphere):
    alone = drawing.alone(renderer, 96)
    light = drawing.over_scene(renderer, 96) - _without(renderer)
    inside = lit(alone)
    assert inside.sum() > 1000
    agree = np.isclose(light, alone, rtol=1e-3, atol=1e-4).all(-1)
    assert agree[inside].mean() > 0.98  # the rim is antialiased by Blender


def test_replacing_hides_what_was_drawn(renderer, sphere):
    plane = scenes.add_plane(half=0.5)
    plane.location.z = 2.0
    plane.data.materials.append(sphere.active_material)
    node = sphere.active_material.node_tree.nodes["Diffraction"]
    base = node.inputs["Base"].links[0].from_node
    base.inputs["Color"].default_value = (0.5, 0.25, 0.125, 1.0)
    node.inputs["Fresnel"].default_value = 1  # dielectric: 1 - R of the light reaches the pigment
    node.inputs["IOR"].default_value = 1.5
    node.inputs["Brightness"].default_value = 0.0
    image = drawing.over_scene(renderer, surface="REPLACE")
    centre = image[48, 48]
    cos_i = 1.0 / np.sqrt(1 + 0.3**2 + 0.2**2)
    assert centre == pytest.approx((1 - 0.04) * 2.0 * cos_i / np.pi * np.array([0.5, 0.25, 0.125]), rel=0.01)


def test_moved_object_camera_and_lamp(renderer, sphere):
    first = drawing.alone(renderer)
    assert box(lit(first)) == pytest.approx([0.27, 0.73, 0.27, 0.73], abs=0.02)
    sphere.location.x = 1.1
    assert box(lit(drawing.alone(renderer))) == pytest.approx([0.52, 0.98, 0.27, 0.73], abs=0.02)
    camera = bpy.context.scene.camera
    camera.matrix_world = Matrix.Translation((1.1, 0, 0)) @ camera.matrix_world
    assert drawing.alone(renderer) == pytest.approx(first, rel=1e-3, abs=2e-3)
    bpy.data.objects["sun"].rotation_quaternion = (0, 1, 0, 0)  # from below
    assert not lit(drawing.alone(renderer))[48, 48]
    bpy.data.lights["sun"].color = (1, 0, 0)
    bpy.data.objects["sun"].rotation_quaternion = (1, 0, 0, 0)
    centre = drawing.alone(renderer)[48, 48]
    assert centre[0] > 0.01 and centre[1:].max() == 0.0


def test_brightness_of_lamp_exposure_and_user(renderer, sphere):
    first = drawing.alone(renderer)
    bpy.data.lights["sun"].energy *= 3
    assert drawing.alone(renderer) == pytest.approx(3 * first, rel=1e-4, abs=1e-6)
    bpy.data.lights["sun"].exposure = 1.0
    assert drawing.alone(renderer, brightness=0.5) == pytest.approx(3 * first, rel=1e-4, abs=1e-6)


def test_modifiers_and_shape_keys(renderer, sphere):
    sphere.modifiers.new("array", "ARRAY").relative_offset_displace = (1.1, 0, 0)
    assert box(lit(drawing.alone(renderer)))[1] > 0.95
    sphere.modifiers.clear()
    assert box(lit(drawing.alone(renderer)))[1] < 0.75
    sphere.shape_key_add(name="Basis")
    key = sphere.shape_key_add(name="large")
    for point in key.data:
        point.co *= 2.0
    key.value = 0.5
    assert box(lit(drawing.alone(renderer))) == pytest.approx([0.16, 0.84, 0.16, 0.84], abs=0.02)


def test_animation(renderer, sphere):
    sphere.location.x = -1.1
    sphere.keyframe_insert("location", frame=1)
    sphere.location.x = 1.1
    sphere.keyframe_insert("location", frame=2)
    for frame, left in ((1, 0.02), (2, 0.52)):
        bpy.context.scene.frame_set(frame)
        assert box(lit(drawing.alone(renderer)))[0] == pytest.approx(left, abs=0.02)


def test_instances(renderer, sphere):
    group = bpy.data.collections.new("group")
    group.objects.link(sphere)
    bpy.context.scene.collection.objects.unlink(sphere)
    assert not lit(drawing.alone(renderer)).any()
    for x in (-1.1, 1.1):
        empty = bpy.data.objects.new("instance", None)
        empty.instance_type = "COLLECTION"
        empty.instance_collection = group
        empty.location.x = x
        bpy.context.scene.collection.objects.link(empty)
    image = drawing.alone(renderer)
    assert box(lit(image)) == pytest.approx([0.02, 0.98, 0.27, 0.73], abs=0.02)
    assert len(renderer.meshes) == 1  # both draw the same mesh
    sphere.data.transform(Matrix.Diagonal((1, 0.5, 1, 1)))
    sphere.data.update()
    assert box(lit(drawing.alone(renderer))) == pytest.approx([0.02, 0.98, 0.385, 0.615], abs=0.02)


def test_mirrored_object_shows_its_outside(renderer, sphere):
    sphere.scale = (-1, 1, 1)
    mask = lit(drawing.alone(renderer))
    assert box(mask) == pytest.approx([0.27, 0.73, 0.27, 0.73], abs=0.02)
    plane = scenes.add_plane(half=0.2)
    plane.data.materials.append(sphere.active_material)
    bpy.data.objects.remove(sphere)
    assert lit(drawing.alone(renderer))[48, 48]
    plane.data.flip_normals()
    assert not lit(drawing.alone(renderer)).any()


def test_undo(renderer, sphere):
    first = drawing.alone(renderer)
    bpy.ops.ed.undo_push(message="start")
    sphere.data.transform(Matrix.Scale(0.5, 4))
    bpy.ops.ed.undo_push(message="smaller")
    assert box(lit(drawing.alone(renderer)))[0] > 0.35
    bpy.ops.ed.undo()
    assert drawing.alone(renderer) == pytest.approx(first, abs=1e-6)


def test_saved_file_and_disabled_add_on(renderer, sphere, tmp_path):
    first = drawing.alone(renderer)
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert len(renderer.meshes) == len(renderer.tables) == 0
    bpy.ops.wm.open_mainfile(filepath=path)
    assert drawing.alone(renderer) == pytest.approx(first, abs=1e-6)

    from diffraction_shader.addon import viewport
    from diffraction_shader.addon.viewport import handlers

    viewport.unregister()
    try:
        assert len(renderer.meshes) == len(renderer.tables) == 0
        for where in (bpy.app.handlers.depsgraph_update_post, bpy.app.handlers.undo_post, bpy.app.handlers.load_pre):
            assert not [f for f in where if f.__module__ == handlers.__name__]
    finally:
        viewport.register()
    assert drawing.alone(renderer) == pytest.approx(first, abs=1e-6)


def test_switches(renderer, sphere):
    sphere.active_material.diffraction_viewport.show = False
    assert not lit(drawing.alone(renderer)).any()
    sphere.active_material.diffraction_viewport.show = True
    assert lit(drawing.alone(renderer)).any()
    sphere.hide_set(True)
    image = drawing.over_scene(renderer) - _without(renderer)
    assert not lit(image).any()


def test_scene_without_lamps_gets_the_studio(renderer, sphere):
    bpy.data.objects.remove(bpy.data.objects["sun"])
    first = drawing.alone(renderer)
    assert lit(first)[48, 48]
    camera = bpy.context.scene.camera
    camera.matrix_world = Matrix.Rotation(np.pi / 2, 4, "Z") @ camera.matrix_world
    sphere.rotation_euler.z = np.pi / 2
    # The studio turns with the viewer; the coarse sphere's rim falls on other pixels.
    assert np.isclose(drawing.alone(renderer), first, rtol=0.01, atol=1e-3).all(-1).mean() > 0.99


def test_new_bake_is_shown(renderer, sphere, tmp_path):
    first = drawing.alone(renderer)
    tables.make_table(tmp_path / "table.exr", lambda u, v, w: 2 * tables.lobes(u, v, w))
    assert drawing.alone(renderer) == pytest.approx(2 * first, rel=5e-3, abs=1e-4)


def test_missing_table_is_said_once(renderer, sphere, tmp_path, capsys):
    from diffraction_shader.addon.viewport import looks

    (tmp_path / "table.exr").unlink()
    renderer.clear()
    view_matrix, projection = drawing.eye(16)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for _ in range(3):
        assert renderer.draw(depsgraph, view_matrix, projection, looks.View(), False, lambda ob: True) == 0
    assert "table.exr" in renderer.message and "bake" in renderer.message
    assert capsys.readouterr().out.count("Diffraction:") == 1


def test_lamp_in_a_collection_that_an_empty_shows(renderer, sphere):
    """The rig's sun shines as the same sun does in the scene; hidden with the empty the studio's lamps come."""
    first = drawing.alone(renderer)
    rig = bpy.data.collections.new("rig")
    sun = bpy.data.objects["sun"]
    rig.objects.link(sun)
    bpy.context.scene.collection.objects.unlink(sun)
    studio = drawing.alone(renderer)
    empty = bpy.data.objects.new("rig", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", rig
    bpy.context.scene.collection.objects.link(empty)
    assert drawing.alone(renderer) == pytest.approx(first, rel=1e-3, abs=1e-4)
    assert not np.allclose(studio, first, rtol=0.1)


def test_materials_of_nodes_are_drawn_unless_eevee_shows_them(renderer, sphere, tmp_path):
    first = drawing.alone(renderer)
    sphere.data.materials.clear()
    scene.give_material(sphere, tmp_path / "table.exr", fresnel="NONE", implementation="NODES")
    assert drawing.alone(renderer) == pytest.approx(first, rel=1e-4, abs=1e-5)

    from diffraction_shader.addon.viewport import looks

    view, projection = drawing.eye(16)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for surface, count in (("ADD", 0), ("REPLACE", 1)):
        look = looks.View(surface=surface)
        assert renderer.draw(depsgraph, view, projection, look, False, lambda ob: True, skips_nodes=True) == count
