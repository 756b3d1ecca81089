# SPDX-License-Identifier: GPL-3.0-or-later
"""3-D views: the modes of shading, what a view leaves out, and the buttons that make pictures."""

import re
import time

import numpy as np
import pytest

VIEW = "area().spaces.active"
NO_LAMPS = "Material Preview with Scene Lights off: the studio's light alone"


@pytest.fixture(scope="module")
def surface(enabled):
    """A ball with a grating, and nothing in the view but surfaces.

    No edges are smoothed: Blender does that over some redraws, and two pictures would differ by how many there were.
    """
    enabled.new_file()
    smoothing = enabled.look("bpy.context.preferences.system.viewport_aa")
    enabled.run("bpy.context.preferences.system.viewport_aa = 'OFF'")
    enabled.run(f"""
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.object.select_all(action='SELECT')
    bpy.data.objects['Camera'].select_set(False)
    bpy.data.objects['Light'].select_set(False)
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_uv_sphere_add(radius=2.4, segments=64, ring_count=32)
    bpy.ops.object.shade_smooth()
    bpy.ops.diffraction.make_preset(preset='sinusoid', size_um=16, pixels=160, look=True)
    bpy.ops.diffraction.bake(detail=0.3)
    bpy.ops.diffraction.apply_material(implementation='NODES', dark_ground=True)
bpy.data.objects['Light'].data.type = 'SUN'
bpy.data.objects['Light'].data.energy = 3.0
{VIEW}.overlay.show_overlays = False
{VIEW}.show_gizmo = False
""")
    enabled.console()
    yield enabled
    enabled.run(f"bpy.context.preferences.system.viewport_aa = {smoothing!r}")


def drawn(desk, name):
    """How much the handler changes each pixel of the view."""
    with_it = desk.picture(name)
    desk.run("bpy.context.scene.diffraction_viewport.show = False")
    without = desk.picture(f"{name}_off")
    desk.run("bpy.context.scene.diffraction_viewport.show = True")
    return np.abs(with_it - without).max(-1)


def coloured(picture):
    """The part of the pixels that have a colour."""
    return float(np.mean(picture.max(-1) - picture.min(-1) > 0.15))


@pytest.mark.parametrize("shading", ["SOLID", "MATERIAL"])
def test_colours_in_shading(surface, shading):
    surface.run(f"{VIEW}.shading.type = {shading!r}")
    for _ in range(60 if shading == "MATERIAL" else 0):  # EEVEE shows white until its shader is compiled
        if coloured(surface.picture(f"30_{shading.lower()}")) > 0.001:
            break
        surface.watch(5.0)
    for _ in range(40):  # the studio's picture is made beside the window
        changed = drawn(surface, f"30_{shading.lower()}")
        if np.mean(changed > 0.1) > 0.003:
            break
        surface.watch(5.0)
    assert np.mean(changed > 0.1) > 0.003, NO_LAMPS if shading == "MATERIAL" else shading
    assert np.mean(changed > 0.1) < 0.5
    surface.run(f"{VIEW}.shading.type = 'SOLID'")
    assert surface.console() == []


def test_rendered_view_of_eevee_has_colours(surface):
    surface.run(f"{VIEW}.shading.type = 'RENDERED'")
    for _ in range(60):  # its shader is compiled beside the window
        picture = surface.picture("31_rendered")
        if coloured(picture) > 0.001:
            break
        surface.watch(5.0)
    surface.run(f"{VIEW}.shading.type = 'SOLID'")
    assert coloured(picture) > 0.001
    assert surface.console() == []


def test_clipping_region_by_alt_b(surface):
    whole = drawn(surface, "32_unclipped") > 0.05
    x, y, width, height = surface.look("rectangle('VIEW_3D', 'WINDOW')")
    middle = x + width // 2
    surface.driver.point(x + 20, y + 20)
    surface.driver.key("B", alt=True)
    surface.drag((x + 20, y + 20), (middle, y + height - 20))
    clipped = drawn(surface, "33_clipped") > 0.05
    assert surface.look(f"{VIEW}.region_3d.use_clip_planes")
    surface.over_view()
    surface.driver.key("B", alt=True)
    surface.settle()
    assert whole[:, width // 2 + 8 :].any()
    assert not clipped[:, width // 2 + 8 :].any()
    assert clipped[:, : width // 2 - 8].any()
    assert not surface.look(f"{VIEW}.region_3d.use_clip_planes")
    assert surface.console() == []


def test_passepartout_covers_it(surface):
    surface.run(f"""
camera = bpy.data.objects['Camera']
camera.data.show_passepartout, camera.data.passepartout_alpha, camera.data.lens = True, 1.0, 200.0
{VIEW}.region_3d.view_perspective = 'CAMERA'
{VIEW}.overlay.show_overlays = True
""")
    changed = drawn(surface, "34_passepartout") > 0.05
    frame = surface.look("addon('viewport.manners').camera_frame(bpy.data.objects['Camera'], bpy.context.scene,"
                         f" {VIEW}.region_3d.perspective_matrix)")  # fmt: skip
    surface.run(f"{VIEW}.region_3d.view_perspective = 'PERSP'\n{VIEW}.overlay.show_overlays = False")
    height, width = changed.shape
    inside = np.zeros_like(changed)
    left, bottom, right, top = frame
    inside[
        int((1 - top) * height) - 2 : int((1 - bottom) * height) + 3, int(left * width) - 2 : int(right * width) + 3
    ] = True
    assert changed[inside].any() and not changed[~inside].any()
    assert surface.console() == []


def test_local_view_of_another_object_shows_none(surface):
    surface.run("""
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.mesh.primitive_cube_add(location=(0, 0, 4))
    bpy.ops.view3d.localview(frame_selected=False)
""")
    changed = drawn(surface, "35_local_view")
    surface.run("""
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.view3d.localview(frame_selected=False)
    bpy.ops.object.delete()
bpy.context.view_layer.objects.active = bpy.data.objects['Sphere']
bpy.data.objects['Sphere'].select_set(True)
""")
    assert not (changed > 0.02).any()
    assert surface.console() == []


def test_xray_lets_the_surface_through(surface):
    surface.run(f"{VIEW}.shading.show_xray = True\n{VIEW}.shading.xray_alpha = 0.3")
    changed = drawn(surface, "36_xray")
    surface.run(f"{VIEW}.shading.show_xray = False")
    solid = drawn(surface, "36_solid")
    assert 0.0 < changed.sum() < 0.8 * solid.sum()
    assert surface.console() == []


@pytest.mark.parametrize("mode", ["EDIT", "WEIGHT_PAINT", "SCULPT"])
def test_work_on_the_mesh_is_not_covered(surface, mode):
    surface.run(f"with within('VIEW_3D', 'WINDOW'): bpy.ops.object.mode_set(mode={mode!r})")
    changed = drawn(surface, f"37_{mode.lower()}")
    surface.run("with within('VIEW_3D', 'WINDOW'): bpy.ops.object.mode_set(mode='OBJECT')")
    assert not (changed > 0.02).any()
    assert np.count_nonzero(drawn(surface, "37_object") > 0.05) > 1000
    assert surface.console() == []


def test_button_renders_the_viewports_picture_twice(surface):
    colours = []
    for brightness in (1.0, 0.2):
        surface.run(f"bpy.context.scene.diffraction_viewport.brightness = {brightness}")
        before = surface.look("len(bpy.context.window_manager.windows)")
        surface.press("diffraction.viewport_render")
        surface.settle()
        colours.append(surface.image("Viewport Picture"))
        if surface.look("len(bpy.context.window_manager.windows)") > before:
            surface.shot("38_viewport_picture")
        surface.close_windows()
    assert coloured(colours[0]) > 0.0003
    assert colours[1].mean() < colours[0].mean()
    surface.run("bpy.context.scene.diffraction_viewport.brightness = 1.0")
    assert surface.console() == []


def test_evaluate_twice_with_other_light(surface):
    surface.open_panel("evaluate", above="viewport_render")
    maps = []
    for theta in (0, 40):
        surface.enter("map_theta", theta)
        surface.press("diffraction.brdf_map")
        maps.append(surface.image(surface.state("map_image")))
    surface.shot("39_brdf_map")
    assert np.abs(maps[0] - maps[1]).max() > 0.1
    surface.open_panel("reflectance", above=re.compile("show_image.*BRDF"))
    told = []
    for theta in (20, 45):
        surface.enter("plot_theta", theta)
        surface.press("diffraction.reflectance")
        told.append(surface.state("plot_result"))
    surface.shot("39_reflectance")
    assert told[0] and told[1] and told[0] != told[1]
    assert surface.console() == []


def test_open_large_shows_the_levelling(surface):
    surface.press("diffraction.preview_levelling")
    before = surface.look("len(bpy.context.window_manager.windows)")
    surface.press("diffraction.show_image")
    surface.settle()
    shown = surface.look("[a.spaces.active.image.name for w in bpy.context.window_manager.windows"
                         " for a in w.screen.areas if a.type == 'IMAGE_EDITOR' and a.spaces.active.image]")  # fmt: skip
    surface.watch(1.0)  # it is fitted once it has been drawn
    surface.shot("40_open_large")
    room = surface.look("[(s.zoom[0] * s.image.size[0], r.width) for w in bpy.context.window_manager.windows"
                        " for a in w.screen.areas if a.type == 'IMAGE_EDITOR' for s in [a.spaces.active]"
                        " for r in a.regions if r.type == 'WINDOW']")  # fmt: skip
    windows = surface.look("len(bpy.context.window_manager.windows)")
    surface.press("diffraction.show_image")  # a second click takes the editor that is there
    assert surface.look("len(bpy.context.window_manager.windows)") == windows
    surface.close_windows()
    assert windows == before + 1 and "Diffraction Levelling" in shown
    assert all(0.5 * width < picture <= width for picture, width in room) and room
    assert surface.console() == []


def test_a_sky_world_lights_the_view_and_the_window_does_not_wait_for_it(surface):
    surface.run(f"""
{VIEW}.shading.type = 'SOLID'
bpy.data.objects['Light'].hide_set(True)
tree = bpy.context.scene.world.node_tree
tree.nodes.clear()
sky, ground, output = (tree.nodes.new('ShaderNode' + n) for n in ('TexSky', 'Background', 'OutputWorld'))
tree.links.new(sky.outputs[0], ground.inputs[0])
tree.links.new(ground.outputs[0], output.inputs[0])
""")
    skies = "addon('viewport.kept').renderer.skies"
    shares = []
    for elevation in (0.3, 1.2):
        surface.run(f"sky.sun_elevation = {elevation}")
        surface.settle()
        surface.driver.gaps()
        deadline = time.monotonic() + 600.0
        while surface.look(f"bool({skies}._waiting)") or not surface.look(f"len({skies}._held)"):
            assert time.monotonic() < deadline, surface.look(f"{skies}.message")
            surface.watch(1.0)
        busy = max((work for _, work in surface.driver.gaps()), default=0.0)
        assert not busy > 1.0  # the first drawing under a sky compiles a shader
        shares.append(drawn(surface, f"41_sky_{elevation}"))
        assert (shares[-1] > 0.02).any() and surface.look(f"{skies}.message") == ""
    assert np.abs(shares[0] - shares[1]).max() > 0.02
    surface.run("bpy.data.objects['Light'].hide_set(False)")
    assert surface.console() == []
