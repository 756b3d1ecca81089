# SPDX-License-Identifier: GPL-3.0-or-later
"""The drawing does as the view asks: clipping regions, render borders, X-ray, and objects that the user works on."""

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.support.blender import drawing, scenes


def draw(renderer, asks, size=64, **view):
    """What the renderer draws on black: (size, size, 3), row 0 at the bottom."""
    bpy.context.scene.camera.matrix_world = Matrix.Translation((0, 0, 10))  # x to the right, y upwards
    return drawing.alone(renderer, size, asks=asks, **view)


@pytest.fixture
def view(sphere):
    """Context, space and region data of a 3-D view in Solid."""
    from diffraction_shader.addon.viewport import offscreen

    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        override["space_data"].shading.type = "SOLID"
        yield bpy.context, override["space_data"], override["region_data"]


@pytest.mark.parametrize("surface", ["ADD", "REPLACE"])
def test_clipping_planes_cut(renderer, sphere, surface):
    from diffraction_shader.addon.viewport.manners import Manners

    whole = draw(renderer, Manners(), surface=surface)
    planes = ((1.0, 0.0, 0.0, 0.0), (0.0, -1.0, 0.0, 0.5))  # x > 0 and y < 0.5
    cut = draw(renderer, Manners(clip=planes), surface=surface)
    # Extent 2.2 over 64 pixels: the planes fall on pixel 32 and on 46.5.
    assert np.array_equal(cut[:46, 33:], whole[:46, 33:]) and whole[:46, 33:].max() > 0.01
    assert cut[:, :31].max() == 0.0 and cut[48:].max() == 0.0


def test_a_clipping_region_is_read_from_the_view(renderer, view):
    from diffraction_shader.addon.viewport import manners

    context, space, region = view
    assert manners.of_view(context, space, region, eevee=False) == manners.PLAIN
    region.clip_planes = [(1, 0, 0, 0), (-1, 0, 0, 2), (0, 1, 0, 0), (0, -1, 0, 2), (0, 0, 0, 0), (0, 0, 0, 0)]
    region.use_clip_planes = True
    try:
        asks = manners.of_view(context, space, region, eevee=False)
    finally:
        region.use_clip_planes = False
    assert asks.clip == ((1, 0, 0, 0), (-1, 0, 0, 2), (0, 1, 0, 0), (0, -1, 0, 2))
    assert draw(renderer, asks)[:31].max() == 0.0


def test_xray_is_as_faint_as_its_surfaces(renderer, view):
    from diffraction_shader.addon.viewport import manners

    context, space, region = view
    whole = draw(renderer, manners.PLAIN)
    space.shading.show_xray, space.shading.xray_alpha = True, 0.25
    try:
        asks = manners.of_view(context, space, region, eevee=False)
    finally:
        space.shading.show_xray = False
    assert draw(renderer, asks) == pytest.approx(0.25 * whole, rel=1e-4, abs=1e-6)


def test_render_borders_bound_what_eevee_draws(renderer, view):
    import gpu
    from diffraction_shader.addon.viewport import manners

    context, space, region = view
    space.use_render_border = True
    space.render_border_min_x, space.render_border_max_x = 0.5, 1.0
    space.render_border_min_y, space.render_border_max_y = 0.0, 0.5
    target = gpu.types.GPUOffScreen(64, 64)
    try:
        with target.bind():
            asks = manners.of_view(context, space, region, eevee=True)
            assert manners.of_view(context, space, region, eevee=False).border is None
            assert asks.border == pytest.approx((32.0, 0.0, 64.0, 32.0))
            # Through a camera its own border counts, as part of what the camera takes in.
            region.view_perspective, space.camera = "CAMERA", context.scene.camera
            assert manners.of_view(context, space, region, eevee=True).border is None
            render = context.scene.render
            render.resolution_x = render.resolution_y = 100
            render.use_border = True
            render.border_min_x, render.border_max_x = 0.25, 0.75
            render.border_min_y, render.border_max_y = 0.5, 1.0
            region.update()
            frame = manners.camera_frame(context.scene.camera, context.scene, region.perspective_matrix)
            border = np.array(manners.of_view(context, space, region, eevee=True).border) / 64
    finally:
        target.free()
        region.view_perspective, space.use_render_border = "PERSP", False
    left, bottom, right, top = frame
    across, up = right - left, top - bottom
    expected = left + 0.25 * across, bottom + 0.5 * up, left + 0.75 * across, top
    assert border == pytest.approx(expected, abs=1e-4) and across > 0.1 and up > 0.1
    whole = draw(renderer, manners.PLAIN)
    image = draw(renderer, manners.Manners(border=(32.0, 0.0, 64.0, 32.0)))
    assert np.array_equal(image[:32, 32:], whole[:32, 32:])
    assert image[32:].max() == 0.0 and image[:, :32].max() == 0.0


def test_the_frame_of_a_camera(sphere):
    from diffraction_shader.addon.viewport import manners

    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 200, 100
    scene.camera.matrix_world = Matrix.Translation((0.3, 0.2, 5.0))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for kind in ("ORTHO", "PERSP"):
        scene.camera.data.type = kind
        bpy.context.view_layer.update()
        projection = scene.camera.calc_matrix_camera(depsgraph, x=200, y=100)
        to_clip = projection @ scene.camera.matrix_world.inverted()
        assert manners.camera_frame(scene.camera, scene, to_clip) == pytest.approx((0, 0, 1, 1), abs=1e-5)
        wider = Matrix.Diagonal((0.5, 0.5, 1, 1)) @ to_clip
        assert manners.camera_frame(scene.camera, scene, wider) == pytest.approx((0.25, 0.25, 0.75, 0.75), abs=1e-5)


@pytest.mark.parametrize(
    ("mode", "solid", "eevee"),
    [
        ("OBJECT", False, False),
        ("EDIT", True, True),
        ("WEIGHT_PAINT", True, True),
        ("SCULPT", True, False),
        ("VERTEX_PAINT", True, False),
        ("TEXTURE_PAINT", True, False),
    ],
)
def test_where_the_user_works(sphere, mode, solid, eevee):
    from diffraction_shader.addon.viewport import manners

    bpy.context.view_layer.objects.active = sphere
    sphere.select_set(True)
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode=mode)
    try:
        assert manners.away(sphere, eevee=False) == solid
        assert manners.away(sphere, eevee=True) == eevee
        assert bool(manners.modes(bpy.context)) == (mode != "OBJECT")
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def test_an_object_in_edit_mode_is_left_alone_and_its_neighbour_is_not(renderer, sphere):
    """The list of what is drawn follows the mode without any change of the scene."""
    from diffraction_shader.addon.viewport import looks, manners

    plane = scenes.add_plane("plane", half=0.2)
    plane.data.materials.append(sphere.active_material)
    bpy.context.view_layer.objects.active = sphere
    view, projection = (np.array(m) for m in drawing.eye(16))

    def count():
        return renderer.draw(
            bpy.context.evaluated_depsgraph_get(), view, projection, looks.View(), False,
            lambda ob: not manners.away(ob, eevee=False), list_key=manners.modes(bpy.context),
        )  # fmt: skip

    assert count() == 2
    bpy.ops.object.mode_set(mode="EDIT")
    assert count() == 1
    bpy.ops.object.mode_set(mode="OBJECT")
    assert count() == 2
