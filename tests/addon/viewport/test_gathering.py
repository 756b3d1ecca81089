# SPDX-License-Identifier: GPL-3.0-or-later
"""A view that stands still gathers light of the surroundings over its drawings."""

import bpy
import colour
import gpu
import numpy as np
import pytest

from tests.support.blender import drawing, materials, scenes, tables
from tests.support.blender.worlds import picture_world, spotted_sky, white_world

SIZE = 40


@pytest.fixture
def sphere(renderer, tmp_path):
    """A sphere of orders a few hundredths wide under a picture of the sky."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    ob = scenes.add_sphere(segments=64, rings=32)
    scenes.add_camera((0.4, -1, 0.5))
    materials.diffracting(ob, tmp_path / "t.exr", fresnel="NONE")
    picture_world(spotted_sky())
    return ob


def middle():
    """Pixels well inside the sphere's rim."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5 - SIZE / 2
    return np.hypot(x, y) < 0.8 * SIZE / 2.2


def gathered(renderer, **view):
    """Drawings of a view until it asks for no more."""
    while True:
        yield drawing.alone(renderer, SIZE, gathers="view", **view)
        if not renderer.gathering.wants_more("view"):
            return


def differs(one, other):
    """Mean Delta E 2000 of linear RGB."""
    lab = [
        colour.XYZ_to_Lab(colour.RGB_to_XYZ(np.clip(rgb, 0.0, 1.0), "sRGB", apply_cctf_decoding=False))
        for rgb in (one, other)
    ]
    return colour.delta_E(*lab, method="CIE 2000").mean()


def in_many(renderer, monkeypatch, points):
    """The view by 4096 directions in one drawing."""
    from diffraction_shader.addon.viewport import drawing as viewport_drawing

    with monkeypatch.context() as patch:
        patch.setitem(viewport_drawing.SKY_POINTS, points, 4096)
        return drawing.alone(renderer, SIZE, points=points)


def test_the_mean_comes_close_to_many_directions(renderer, sphere, monkeypatch):
    points = 4
    found = list(gathered(renderer, points=points))
    many = in_many(renderer, monkeypatch, points)
    inside = middle()
    assert many[inside].mean() > 0.05
    assert np.array_equal(found[0], drawing.alone(renderer, SIZE, points=points))  # the first is drawn as ever
    assert differs(many[inside], found[-1][inside]) < 1.0 < differs(many[inside], found[0][inside])
    assert found[-1][inside].mean(0) == pytest.approx(many[inside].mean(0), rel=0.03)
    assert np.array_equal(found[-1].any(-1), many.any(-1))  # nothing spills over the rim


def test_what_changes_begins_anew(renderer, sphere):
    first = list(gathered(renderer))
    camera = bpy.context.scene.camera
    camera.matrix_world = camera.matrix_world @ camera.matrix_world.Rotation(0.4, 4, "Z")
    assert np.array_equal(drawing.alone(renderer, SIZE, gathers="view"), drawing.alone(renderer, SIZE))
    assert renderer.gathering.wants_more("view")
    turned = list(gathered(renderer))
    assert not np.allclose(turned[-1], first[-1], rtol=0.1)
    sphere.active_material.node_tree.nodes["Diffraction"].inputs["Rotation"].default_value = 1.0
    bpy.context.view_layer.update()
    assert np.array_equal(drawing.alone(renderer, SIZE, gathers="view"), drawing.alone(renderer, SIZE))
    white_world()  # has nothing to gather
    drawing.alone(renderer, SIZE, gathers="view")
    assert not renderer.gathering.wants_more("view")


def over_depth(renderer, **options):
    """What the renderer adds to the view, whose depth is there."""
    from diffraction_shader.addon.viewport import looks, offscreen

    view, projection = drawing.eye(SIZE)
    target = gpu.types.GPUOffScreen(SIZE, SIZE, format="RGBA32F")
    scene = bpy.context.scene
    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        override["space_data"].shading.type = "SOLID"
        target.draw_view3d(
            scene, bpy.context.view_layer, override["space_data"], override["region"], view, projection,
            do_color_management=False,
        )  # fmt: skip
        with target.bind():
            gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 0))
            renderer.draw(
                bpy.context.evaluated_depsgraph_get(), np.array(view), np.array(projection), looks.View(points=16),
                False, lambda ob: True, **options,
            )  # fmt: skip
    found = offscreen.read(target)[..., :3].astype(float)
    target.free()
    return found


def test_what_lies_behind_is_hidden_and_lamps_are_added(renderer, sphere, tmp_path, monkeypatch):
    """A second sphere half behind the first, without light of the surroundings, and a sun."""
    from diffraction_shader.addon.viewport import drawing as viewport_drawing

    other = scenes.add_sphere(segments=64, rings=32)
    other.location = (0.5, 1.5, 0.0)
    materials.diffracting(other, tmp_path / "t.exr", fresnel="NONE", environment=0)
    scenes.add_sun((0.3, -0.8, 0.6))
    bpy.context.view_layer.update()
    found = over_depth(renderer, gathers="view")
    while renderer.gathering.wants_more("view"):
        found = over_depth(renderer, gathers="view")
    monkeypatch.setitem(viewport_drawing.SKY_POINTS, 16, 4096)
    wanted = over_depth(renderer)
    off = np.abs(found - wanted) / (wanted + 0.05)
    assert np.percentile(off, 99) < 0.15 and off.mean() < 0.02


def test_the_handler_gathers_and_leaves_the_gpu_as_it_was(renderer, sphere, tmp_path):
    from diffraction_shader.addon.viewport import handlers, offscreen, surroundings

    view, projection = drawing.eye(SIZE)
    target = gpu.types.GPUOffScreen(SIZE, SIZE, format="RGBA32F")
    pictures = []
    scene = bpy.context.scene
    # What a window shows once it is there.
    renderer.skies.get(surroundings.of_world(scene.world).sky, wait=True)
    renderer.tables.get(tmp_path / "t.exr", wait=True)
    renderer.directions.texture(tmp_path / "t.exr", wait=True)
    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        override["space_data"].shading.type = "SOLID"
        key = override["region"].as_pointer()
        for _ in range(4):
            with target.bind(), gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
                gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 0), depth=1.0)
                gpu.matrix.load_matrix(view)
                gpu.matrix.load_projection_matrix(projection)
                before = gpu.state.depth_mask_get(), gpu.state.depth_test_get(), gpu.state.blend_get()
                handlers.draw_view()
                assert (gpu.state.depth_mask_get(), gpu.state.depth_test_get(), gpu.state.blend_get()) == before
            pictures.append(offscreen.read(target))
    assert not renderer.message
    assert renderer.gathering.wants_more(key)
    assert pictures[0][..., :3].max() > 0.05
    assert all(each.any(-1).sum() == pictures[0].any(-1).sum() for each in pictures)
    assert not np.array_equal(pictures[2], pictures[3])
