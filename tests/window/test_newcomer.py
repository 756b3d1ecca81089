# SPDX-License-Identifier: GPL-3.0-or-later
"""A newcomer's way, by clicks only: preset, bake, apply, F12, on what Blender starts with."""

import colorsys


def saturated(picture):
    """The largest saturation of what is neither black nor white."""
    pixels = picture.reshape(-1, 3)
    bright = pixels[(pixels.max(1) > 0.1) & (pixels.min(1) < 0.97)]
    return max((colorsys.rgb_to_hsv(*pixel)[1] for pixel in bright), default=0.0)


def test_from_a_preset_to_a_coloured_picture(enabled):
    enabled.new_file()
    enabled.console()
    # For speed; all else is as Blender starts, grey cube and grey world among it.
    enabled.run("bpy.context.scene.render.resolution_percentage = 15\nbpy.context.scene.eevee.taa_render_samples = 8")
    clicks = 1  # the tab
    enabled.open_panel("preset", above="diffraction.import_scan")
    clicks += 1
    for button in ("make_preset", "bake", "apply_material"):
        enabled.press(f"diffraction.{button}")
        clicks += 1
    enabled.shot("20_newcomer")
    picture = enabled.render()
    enabled.shot("21_newcomer_render")
    assert clicks <= 6
    assert picture.max() > 0.15
    assert saturated(picture) > 0.15
    assert enabled.console() == []
