# SPDX-License-Identifier: GPL-3.0-or-later
"""Light drawn in a 3-D view passes through the scene's view transform as a render does."""

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, extension, tables


def decoded(encoded):
    """sRGB values as light."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


@pytest.mark.parametrize(
    ("transform", "look", "exposure", "gamma"),
    [("Standard", "None", 0.0, 1.0), ("Standard", "None", -1.5, 1.3), ("AgX", "AgX - Punchy", 0.7, 1.0),
     ("Filmic", "None", 0.0, 1.0), ("Khronos PBR Neutral", "None", 0.0, 1.0)],
)  # fmt: skip
def test_view_transform(renderer, sphere, transform, look, exposure, gamma):
    """What the shader looks up is what Blender makes of the same light in a saved picture."""
    from diffraction_shader.addon.viewport.data import display

    settings = bpy.context.scene.view_settings
    settings.view_transform, settings.look = transform, look
    settings.exposure, settings.gamma = exposure, gamma
    linear = drawing.alone(renderer)
    renderer.display.texture(bpy.context.scene, wait=True)
    drawn = drawing.alone(renderer, display=True)
    pixels = np.ones((*linear.shape[:2], 4), np.float32)
    pixels[..., :3] = linear
    saved = decoded(display.save_as_render(pixels, bpy.context.scene)[..., :3])
    error = np.abs(drawn - saved)[linear.sum(-1) > 0]
    assert error.mean() < 0.007 and np.percentile(error, 99) < 0.03
    if transform == "Standard":
        assert drawn == pytest.approx(np.clip(linear * 2.0**exposure, 0, 1) ** (1 / gamma), abs=0.03)


def test_handler_draws_through_the_display(renderer, sphere):
    """The handler that Blender calls, in a 3-D view, over the view's depth."""
    import gpu
    from diffraction_shader.addon.viewport import handlers, offscreen

    window = bpy.context.scene
    window.view_settings.view_transform, window.view_settings.look = "Standard", "None"
    renderer.display.texture(window, wait=True)
    view, projection = drawing.eye(64)
    linear = drawing.alone(renderer, 64)
    target = gpu.types.GPUOffScreen(64, 64, format="RGBA32F")

    def handled(**override):
        with target.bind(), gpu.matrix.push_pop(), gpu.matrix.push_pop_projection():
            gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 0), depth=1.0)
            gpu.matrix.load_matrix(view)
            gpu.matrix.load_projection_matrix(projection)
            with bpy.context.temp_override(**override):
                handlers.draw_view()
        return offscreen.read(target)

    with offscreen.view_3d() as override:
        space = override["space_data"]
        space.shading.type = "SOLID"
        image = handled(**override)
        assert image[..., :3] == pytest.approx(np.clip(linear, 0, 1), abs=0.03)
        assert (image[..., 3] == 0).all()  # additive light leaves the overlay transparent
        space.shading.type = "WIREFRAME"
        assert not handled(**override).any()
        space.shading.type = "RENDERED"
        bpy.context.scene.render.engine = "CYCLES"
        assert not handled(**override).any()
        space.shading.type = "SOLID"
        with bpy.context.temp_override(**override):
            bpy.context.window_manager.diffraction_here = False
        assert not handled(**override).any()
        with bpy.context.temp_override(**override):
            bpy.context.window_manager.diffraction_here = True
        bpy.context.scene.diffraction_viewport.show = False
        assert not handled(**override).any()
        bpy.context.scene.diffraction_viewport.show = True
        assert handled(**override).any()
    target.free()


def test_state_of_the_gpu_is_left_as_it_was(renderer, sphere):
    import gpu

    before = gpu.state.blend_get(), gpu.state.depth_test_get(), gpu.state.depth_mask_get()
    drawing.alone(renderer)
    assert (gpu.state.blend_get(), gpu.state.depth_test_get(), gpu.state.depth_mask_get()) == before


def test_solid_view_shows_the_pigment_and_keeps_a_chosen_colour(blender, tmp_path):
    """Over Blender's light grey no structural colour is seen; a colour that somebody chose is theirs."""
    from diffraction_shader.addon.materials import material

    tables.make_table(tmp_path / "table.exr", tables.lobes)
    for chosen, expected in ((None, material.DARK[:3]), ((0.1, 0.5, 0.2, 1.0), (0.1, 0.5, 0.2))):
        shaded = bpy.data.materials.new("shaded")
        extension.give_nodes(shaded)
        shaded.node_tree.nodes.clear()
        if chosen is not None:
            shaded.diffuse_color = chosen
        material.apply(shaded, str(tmp_path / "table.exr"), material.Settings())
        assert tuple(shaded.diffuse_color)[:3] == pytest.approx(expected, abs=1e-6)
