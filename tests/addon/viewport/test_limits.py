# SPDX-License-Identifier: GPL-3.0-or-later
"""What the viewport does where something does not fit or is not there: one message, no exception."""

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, scenes
from tests.support.blender import viewport_scene as scene


def test_table_larger_than_the_gpu_takes(renderer, sphere, monkeypatch, capsys):
    import gpu
    from diffraction_shader.addon.viewport import looks

    monkeypatch.setattr(gpu.capabilities, "max_texture_size_get", lambda: 64)
    view, projection = drawing.eye(16)
    for _ in range(3):
        count = renderer.draw(
            bpy.context.evaluated_depsgraph_get(), view, projection, looks.View(), False, lambda ob: True
        )
        assert count == 0
    assert "too large" in renderer.message and "64" in renderer.message
    assert capsys.readouterr().out.count("Diffraction:") == 1
    monkeypatch.undo()
    renderer.note()  # as after any change of the scene
    assert drawing.alone(renderer).any()


def test_no_gpu_context(renderer, sphere, monkeypatch, tmp_path):
    import gpu

    def absent():
        raise SystemError("GPU functions for drawing are not available in background mode")

    monkeypatch.setattr(gpu.platform, "renderer_get", absent)
    with pytest.raises(RuntimeError, match="no GPU context"):
        bpy.ops.diffraction.viewport_render(filepath=str(tmp_path / "a.png"), width=16, height=16)
    assert not (tmp_path / "a.png").exists()


def test_unknown_failures_are_said_once(renderer, sphere, monkeypatch, capsys):
    from diffraction_shader.addon.viewport import looks
    from diffraction_shader.addon.viewport.data import sources

    def broken(*_):
        raise ValueError("no such shader")

    monkeypatch.setattr(sources, "surface", broken)
    view, projection = drawing.eye(16)
    for _ in range(3):
        renderer.draw(bpy.context.evaluated_depsgraph_get(), view, projection, looks.View(), False, lambda ob: True)
    said = capsys.readouterr()
    assert said.out.count("Diffraction:") == 1 and said.err.count("Traceback") == 1
    assert "Cycles" in renderer.message


def test_relative_brightness_shows_the_lamp_in_a_flat_patch(renderer, tmp_path):
    """A flat patch's mirror image of a sun of irradiance 1 has the luminance 1, whatever it reflects."""
    from precompute.bake.baking import bake
    from precompute.parameters import BakeParameters
    from precompute.scan.heightfield import HeightField

    flat = HeightField(np.zeros((64, 64)), 95e-9, 95e-9)
    bake(flat, BakeParameters(sigma_s_m=0.6e-6)).save(tmp_path / "flat.exr")
    plane = scenes.add_plane()
    scenes.add_sun((0, 0, 1), strength=1.0)
    scenes.add_camera()
    scene.give_material(plane, tmp_path / "flat.exr", fresnel="DIELECTRIC", ior=1.5, conserve_energy=False)
    row = np.array([0.2126, 0.7152, 0.0722])
    assert drawing.alone(renderer, normalisation="RELATIVE")[48, 48] @ row == pytest.approx(1.0, rel=0.02)


@pytest.mark.slow
def test_eevee_depth_does_not_swallow_the_surface(renderer, sphere):
    """EEVEE's depth is sampled elsewhere in each pixel; with slack the sphere is whole, and still hidden by others."""
    import gpu
    from diffraction_shader.addon.viewport import looks, offscreen

    scene_ = bpy.context.scene
    scene_.render.engine = "BLENDER_EEVEE"
    scene_.eevee.taa_samples = 1
    wall = scenes.add_plane("wall", half=5.0)
    wall.location = (5.0, 0.0, 2.0)
    view, projection = drawing.eye(64)
    with offscreen.view_3d() as override, bpy.context.temp_override(**override):
        space = override["space_data"]
        space.shading.type = "RENDERED"
        overlay = space.overlay
        overlay.show_overlays = True
        for name in ("show_floor", "show_axis_x", "show_axis_y", "show_axis_z", "show_extras", "show_ortho_grid"):
            setattr(overlay, name, False)
        target = gpu.types.GPUOffScreen(64, 64, format="RGBA32F")
        target.draw_view3d(scene_, bpy.context.view_layer, space, override["region"], view, projection)
        with target.bind():
            gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 0))
            renderer.draw(
                bpy.context.evaluated_depsgraph_get(), np.array(view), np.array(projection), looks.View(), False,
                lambda ob: True, loose_depth=True,
            )  # fmt: skip
        image = offscreen.read(target)[..., :3].sum(-1)
    # The picture's x may run against the world's: the wall hides one half, whichever.
    whole = drawing.alone(renderer, 64).sum(-1) > 0
    halves = [(image[:, half] > 0)[whole[:, half]].mean() for half in (slice(0, 30), slice(34, 64))]
    assert min(halves) == 0.0 and max(halves) > 0.95
