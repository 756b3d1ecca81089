# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide's pictures of the window: out/window/guide_*.png, for docs/pictures when the panels change."""

import numpy as np
import pytest

#: Stages with the sub-panels that their picture shows.
STAGES = {
    "scan": ["preset"],
    "levelling": [],
    "bake": [],
    "material": ["active"],
    "viewport": [],
    "evaluate": ["reflectance"],
}


@pytest.fixture(scope="module")
def ball(enabled):
    """A ball with the snake's colours under a sun, in Solid view."""
    enabled.new_file()
    enabled.run("""
with within('VIEW_3D', 'WINDOW'):
    for name in ('Cube', 'Camera'): bpy.data.objects.remove(bpy.data.objects[name])
    bpy.ops.mesh.primitive_uv_sphere_add(radius=2.6, segments=128, ring_count=64)
    bpy.ops.object.shade_smooth()
    bpy.ops.diffraction.make_preset(preset='snake', look=True)
    bpy.ops.diffraction.preview_levelling()
    bpy.ops.diffraction.bake()
    bpy.ops.diffraction.apply_material(implementation='NODES', dark_ground=True)
    bpy.ops.diffraction.brdf_map()
    bpy.ops.diffraction.reflectance()
light = bpy.data.objects['Light'].data
light.type, light.energy = 'SUN', 4.0
overlay = area().spaces.active.overlay
area().spaces.active.region_3d.view_distance = 13
overlay.show_extras = overlay.show_floor = overlay.show_axis_x = overlay.show_axis_y = False
""")
    enabled.console()
    return enabled


def test_window(ball):
    picture = ball.picture("guide_window")
    assert np.mean(picture.max(-1) - picture.min(-1) > 0.15) > 0.005
    assert ball.console() == []


@pytest.mark.parametrize("stage", STAGES)
def test_panel(ball, stage):
    ball.run(f"show_only(['main', {stage!r}, *{STAGES[stage]!r}])")
    try:
        ball.open_sidebar()
        assert f"DIFFRACTION_PT_{stage}" in ball.open_panels()
        picture = ball.picture(f"guide_{stage}", region="UI")
    finally:
        ball.run("show_all()")
    # Down to the last line with something in it; the tabs on the right stay outside.
    rows = np.flatnonzero(picture[:, 30:-60].std(axis=1).max(-1) > 0.02)
    ball.keep_picture(f"guide_panel_{stage}", picture[: rows[-1] + 14, :-26])
    assert ball.console() == []
