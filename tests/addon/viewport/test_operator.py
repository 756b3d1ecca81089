# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures by `bpy.ops.diffraction.viewport_render`, and what the sidebar offers."""

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing


def pixels(path):
    """A picture's values as they stand in the file, row 0 at the bottom."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    values = np.empty(image.size[0] * image.size[1] * 4, np.float32)
    image.pixels.foreach_get(values)
    return values.reshape(image.size[1], image.size[0], 4)


def test_exr_holds_the_light(renderer, sphere, tmp_path):
    path = tmp_path / "out" / "light.exr"
    assert bpy.ops.diffraction.viewport_render(
        filepath=str(path), width=96, height=96, surface="REPLACE", samples=1
    ) == {"FINISHED"}
    linear = drawing.alone(renderer, 96, surface="REPLACE", points=16)
    saved = pixels(path)[..., :3]
    inside = linear.sum(-1) > 0
    agree = np.isclose(saved, linear, rtol=2e-3, atol=1e-4).all(-1)
    assert agree[inside].mean() > 0.98  # the rim is antialiased


def test_png_is_the_same_as_a_render_of_the_light(sphere, tmp_path):
    settings = bpy.context.scene.view_settings
    settings.view_transform, settings.look, settings.exposure = "Standard", "None", -1.0
    for name in ("a.exr", "a.png"):
        bpy.ops.diffraction.viewport_render(filepath=str(tmp_path / name), width=64, height=48)
    light, shown = pixels(tmp_path / "a.exr")[..., :3], pixels(tmp_path / "a.png")[..., :3]
    assert light.shape == shown.shape == (48, 64, 3)
    expected = np.clip(light * 0.5, 0, 1)
    expected = np.where(expected <= 0.0031308, 12.92 * expected, 1.055 * expected ** (1 / 2.4) - 0.055)
    assert shown == pytest.approx(expected, abs=1.5 / 255)


def test_the_view_is_left_as_it_was(sphere, tmp_path):
    from diffraction_shader.addon.viewport import offscreen

    with offscreen.view_3d() as view:
        space = view["space_data"]
        space.shading.type = "WIREFRAME"
        space.overlay.show_overlays = True
        engine = bpy.context.scene.render.engine
        bpy.ops.diffraction.viewport_render(filepath=str(tmp_path / "a.png"), width=16, height=16)
        assert space.shading.type == "WIREFRAME" and space.overlay.show_overlays
        assert bpy.context.scene.render.engine == engine
    assert not [i for i in bpy.data.images if i.name.startswith("diffraction")]
    assert len(bpy.data.scenes) == 1


def test_transparent_background(sphere, tmp_path):
    path = tmp_path / "a.png"
    bpy.ops.diffraction.viewport_render(filepath=str(path), width=64, height=64, transparent=True)
    alpha = pixels(path)[..., 3]
    assert alpha[0, 0] == 0.0 and alpha[32, 32] == 1.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"filepath": ""}, "filepath"),
        ({"filepath": "a.xyz"}, "format"),
        ({"filepath": "a.png", "method": "FLSS"}, "terms"),
    ],
)
def test_refusals_are_one_sentence(sphere, tmp_path, arguments, words):
    if arguments["filepath"]:
        arguments = {**arguments, "filepath": str(tmp_path / arguments["filepath"])}
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.diffraction.viewport_render(width=16, height=16, **arguments)
    assert not list(tmp_path.glob("a.*"))


def test_no_camera_no_picture(sphere, tmp_path):
    bpy.context.scene.camera = None
    with pytest.raises(RuntimeError, match="no camera"):
        bpy.ops.diffraction.viewport_render(filepath=str(tmp_path / "a.png"))


def test_panel_offers_all_settings(sphere):
    from diffraction_shader.addon.viewport import panel

    bpy.context.view_layer.objects.active = sphere

    class Stand:
        bl_label = "Viewport"
        layout = bpy.context.window_manager.popmenu_begin__internal("test").layout

    panel.DIFFRACTION_PT_viewport.draw(Stand, bpy.context)
    shown = str(Stand.layout.introspect())
    for name in ("diffraction_here", "surface", "lights", "brightness", "normalisation", "quality", "method"):
        assert name in shown
    assert "WindowManager" in shown or "diffraction_here" in shown


def test_picture_of_the_view(sphere, tmp_path):
    """Without a camera; what the view shows, in the shape of the picture and not of the view."""
    from diffraction_shader.addon.viewport import offscreen

    bpy.context.scene.camera = None
    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        region = override["region_data"]
        region.view_perspective, region.view_distance = "ORTHO", 6.0
        region.view_location, region.view_rotation = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)
        region.update()
    path = tmp_path / "a.exr"
    shown = []
    for brightness in (0.0, 1.0):
        bpy.ops.diffraction.viewport_render(
            filepath=str(path), eye="VIEW", width=80, height=40, brightness=brightness, transparent=True, samples=4
        )
        image = bpy.data.images.load(str(path), check_existing=False)
        shown.append(np.array(image.pixels[:]).reshape(40, 80, 4)[..., :3])
        bpy.data.images.remove(image)
    light = (shown[1] - shown[0]).sum(-1)
    rows, columns = (np.nonzero((light > 1e-4).any(axis))[0] for axis in (1, 0))
    assert abs(np.ptp(rows) - np.ptp(columns)) <= 4 and np.ptp(rows) > 5  # round
    assert columns.mean() == pytest.approx(39.5, abs=2)
