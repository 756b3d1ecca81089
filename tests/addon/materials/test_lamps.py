# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of every type and size: with f = 1 / pi our material must look like a white diffuse one."""

import math

import bpy
import numpy as np
import pytest
from mathutils import Vector

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import light_list, materials, scenes, tables
from tests.support.blender.against_diffuse import both
from tests.support.blender.lamps import LAMPS, add_lamp
from tests.truth import radiance


@pytest.mark.parametrize("name", LAMPS)
def test_lamp_with_constant_f_equals_diffuse(blender, monkeypatch, tmp_path, name):
    kind, data = LAMPS[name]
    add_lamp(kind, **data)
    plane = scenes.add_plane(half=1.0)
    scenes.add_camera((0.1, 0.2, 1.0), extent=1.0)
    # An uneven lamp has a narrow lobe about a random place, which is noisier.
    samples = 2048 if "spread" in data else 256
    ours, diffuse = both(plane, monkeypatch, tmp_path, samples)
    assert ours.mean() == pytest.approx(diffuse.mean(), rel=0.01)
    assert diffuse.mean() > 0.05


def test_eight_lamps_of_all_types_with_constant_f(blender, monkeypatch, tmp_path):
    for number, name in enumerate(list(LAMPS)[:8]):
        kind, data = LAMPS[name]
        angle = 2 * math.pi * number / 8
        add_lamp(kind, (1.6 * math.cos(angle), 1.6 * math.sin(angle), 1.2), name=name, **data)
    plane = scenes.add_plane(half=1.0)
    scenes.add_camera((0.1, 0.2, 1.0), extent=1.0)
    ours, diffuse = both(plane, monkeypatch, tmp_path, samples=512)
    assert ours.mean() == pytest.approx(diffuse.mean(), rel=0.01)


def test_soft_shadow_equals_that_on_diffuse(blender, monkeypatch, tmp_path):
    add_lamp("AREA", (0.0, 0.0, 2.0), size=0.8)
    blocker = scenes.add_plane("blocker", half=0.3)
    blocker.location = (0.2, 0.1, 0.8)
    blocker.visible_camera = False
    bpy.context.scene.cycles.max_bounces = 0  # light that comes back from the blocker is another matter
    plane = scenes.add_plane(half=2.0)
    scenes.add_camera(extent=1.6)
    ours, diffuse = both(plane, monkeypatch, tmp_path, samples=400, size=24)
    assert diffuse.min() < 0.2 * diffuse.max()  # there is a shadow, and half-shadow
    difference = (ours - diffuse)[..., 1]
    scale = diffuse[..., 1].max()
    assert abs(difference.mean()) < 0.005 * scale
    assert np.abs(difference).max() < 0.06 * scale  # noise of 400 samples


def test_wide_area_lamp_averages_the_brdf_over_its_solid_angle(blender, tmp_path):
    """Where f varies across the lamp: against a sum over the lamp's surface."""
    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    lamp = add_lamp("AREA", (0.9, -0.5, 1.1), shape="RECTANGLE", size=1.2, size_y=0.7, energy=40.0)
    plane = scenes.add_plane(half=1.0)
    camera = (0.4, 0.3, 1.0)
    scenes.add_camera(camera, extent=0.02)
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    image = scenes.render(4, samples=4096).mean((0, 1))

    side = (np.arange(64) + 0.5) / 64 - 0.5
    x, y = np.meshgrid(side, side)
    matrix = np.array(lamp.matrix_world)
    points = matrix[:3, 3] + x[..., None] * 1.2 * matrix[:3, 0] + y[..., None] * 0.7 * matrix[:3, 1]
    distance = np.linalg.norm(points, axis=-1, keepdims=True)
    wi = points / distance
    solid_angle = 1.2 * 0.7 / 64**2 * (wi @ matrix[:3, 2]) / distance[..., 0] ** 2
    emitted = 40.0 / (np.pi * 1.2 * 0.7)  # Blender's watts: radiance of a one-sided Lambertian emitter
    wr = np.array(camera) / np.linalg.norm(camera)
    f_cos = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr), xyz_to_rgb_matrix())
    expected = emitted * (f_cos * solid_angle[..., None]).sum((0, 1))
    assert image == pytest.approx(expected, rel=0.01)


def test_materials_follow_lamps_by_themselves(blender, tmp_path):
    """Added, retyped, hidden, removed: the handler keeps the scene's list right without a call."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane = scenes.add_plane()
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    kinds = light_list.kinds
    assert kinds() == [0, 0, 0, 0]
    sun = scenes.add_sun((0, 0, 1), name="a sun")
    assert kinds() == [1, 0, 0, 0]
    lamp = add_lamp("AREA", name="b area")
    assert kinds() == [1, 3, 0, 0]
    lamp.data.shape = "DISK"
    assert kinds() == [1, 4, 0, 0]
    lamp.data.type = "POINT"
    assert kinds() == [1, 2, 0, 0]
    sun.hide_render = True
    assert sorted(kinds()) == [0, 0, 0, 2]
    sun.hide_render = False
    lamp.name = "0 first now"
    assert sorted(kinds()) == [0, 0, 1, 2]
    bpy.data.objects.remove(sun)
    assert kinds() == [2, 0, 0, 0]
    lamp.location = (1, 2, 3)
    assert light_list.place(1) == pytest.approx((1, 2, 3))


def test_more_lamps_than_a_list_holds_are_named(blender, tmp_path, capsys):
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane = scenes.add_plane()
    for number in range(18):
        scenes.add_sun((0, 0.1 * number, 1), strength=18 - number, name=f"sun {number:02}")
    bpy.context.view_layer.update()
    plane.select_set(True)
    state = bpy.context.scene.diffraction
    state.table_path = str(tmp_path / "t.exr")
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    bpy.context.view_layer.update()
    for text in (state.message, capsys.readouterr().out):
        assert "sun 16, sun 17" in text
        assert "sun 15" not in text
        assert "18 lights" in text


def test_settings_are_remembered_and_given_back(blender, tmp_path):
    from diffraction_shader.addon.materials import setup

    lamp = add_lamp("POINT")
    lamp.data.cycles.use_multiple_importance_sampling = True
    scene = bpy.context.scene
    scene.cycles.shading_system = False
    notes = setup.prepare_scene(scene)
    assert len(notes) == 1
    assert scene.cycles.shading_system
    assert lamp.data.cycles.use_multiple_importance_sampling  # other materials live on it
    setup.restore_scene(scene)
    assert not scene.cycles.shading_system
    assert lamp.data.cycles.use_multiple_importance_sampling


def test_settings_are_shown_and_given_back_by_a_button(blender, tmp_path):
    """Nothing sets them again behind the user's back, until Apply is pressed."""
    from diffraction_shader.addon.materials import setup

    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane, lamp, scene = scenes.add_plane(), add_lamp("POINT"), bpy.context.scene
    lamp.data.cycles.use_multiple_importance_sampling = True
    scene.cycles.shading_system = False
    assert not bpy.ops.diffraction.restore_settings.poll()
    bpy.context.view_layer.update()
    plane.select_set(True)
    scene.diffraction.table_path = str(tmp_path / "t.exr")
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}

    def settings():
        return (
            scene.cycles.shading_system,
            lamp.data.cycles.use_multiple_importance_sampling,
            plane.active_material.cycles.use_bump_map_correction,
        )

    assert settings() == (True, True, False)
    assert setup.changes(scene) == ["Open Shading Language on", "Bump map correction off: 1 material"]
    assert bpy.ops.diffraction.restore_settings() == {"FINISHED"}
    assert settings() == (False, True, True)
    add_lamp("SPOT", name="another")  # the handler lists it and leaves the settings alone
    assert light_list.kinds()[1] != 0
    assert settings() == (False, True, True)
    assert setup.changes(scene) == []
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    assert settings() == (True, True, False)


def test_lamp_in_a_linked_collection_that_an_empty_shows(blender, tmp_path):
    """Linked from a library, shown by a turned and animated empty: the picture of a plain lamp."""
    lamp = add_lamp("POINT", (0.5, 0.2, 1.0), shadow_soft_size=0.0)
    collection = bpy.data.collections.new("rig")
    collection.instance_offset = (0.1, 0.2, 0.3)
    collection.objects.link(lamp)
    bpy.context.scene.collection.objects.unlink(lamp)
    bpy.data.libraries.write(str(tmp_path / "rig.blend"), {collection})
    bpy.data.objects.remove(lamp)
    bpy.data.collections.remove(collection)
    with bpy.data.libraries.load(str(tmp_path / "rig.blend"), link=True) as (_, wanted):
        wanted.collections = ["rig"]
    empty = bpy.data.objects.new("shows", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", wanted.collections[0]
    bpy.context.scene.collection.objects.link(empty)
    for frame, angle in ((1, 0.0), (11, 1.2)):
        empty.rotation_euler = (0.1, -0.2, angle)
        empty.keyframe_insert("rotation_euler", frame=frame)
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane = scenes.add_plane()
    scenes.add_camera(extent=1.8)
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE", environment=0)
    bpy.context.scene.frame_set(11)
    instanced = scenes.render(24)
    expected = empty.matrix_world @ (Vector((0.5, 0.2, 1.0)) - Vector((0.1, 0.2, 0.3)))
    assert light_list.place(1) == pytest.approx(tuple(expected), abs=1e-5)
    bpy.data.objects.remove(empty)
    add_lamp("POINT", tuple(expected), shadow_soft_size=0.0)
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE", environment=0)
    plain = scenes.render(24)
    assert plain.max() > 0.1
    assert instanced == pytest.approx(plain, rel=1e-3, abs=1e-5)


def test_light_linking_and_light_groups(blender, tmp_path):
    """A lamp linked to nothing else leaves the material dark; lamps in groups come out in their own passes."""
    import OpenEXR

    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane = scenes.add_plane()
    scenes.add_camera(extent=1.0)
    key, fill = scenes.add_sun((0.1, 0, 1), name="key"), scenes.add_sun((0, 0.6, 0.8), name="fill")
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE", environment=0)
    layer = bpy.context.view_layer
    for lamp in (key, fill):
        layer.lightgroups.add(name=lamp.name)
        lamp.lightgroup = lamp.name
    together = scenes.render(8, samples=64).mean((0, 1))
    settings = bpy.context.scene.render.image_settings
    has_media = hasattr(settings, "media_type")  # not in Blender 4.5
    if has_media:
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format = "OPEN_EXR_MULTILAYER"
    bpy.context.scene.render.filepath = str(tmp_path / "groups.exr")
    bpy.ops.render.render(write_still=True)
    passes = {}
    with OpenEXR.File(str(tmp_path / "groups.exr")) as file:
        for part in file.parts:
            for name, channel in part.channels.items():
                if "Combined_" in name:
                    passes[name.rpartition("_")[2]] = channel.pixels.mean((0, 1))[:3]
    assert passes["key"] + passes["fill"] == pytest.approx(together, rel=1e-3)
    assert min(passes["key"].max(), passes["fill"].max()) > 0.02
    if has_media:
        settings.media_type = "IMAGE"

    other = bpy.data.collections.new("other")
    fill.light_linking.receiver_collection = other
    other.objects.link(scenes.add_plane("elsewhere", half=0.01))
    assert scenes.render(8, samples=64).mean((0, 1)) == pytest.approx(passes["key"], rel=1e-3)
