# SPDX-License-Identifier: GPL-3.0-or-later
"""A working day at the window, each button pressed at least twice with other values in the panel."""

import json

import pytest


def test_install_from_disk_and_enable(desk, zipped):
    options = f"filepath={str(zipped)!r}, repo='user_default', enable_on_install=True"
    desk.run(f"bpy.ops.extensions.package_install_files({options})")
    assert desk.look("[a.module for a in bpy.context.preferences.addons if 'diffraction' in a.module]")
    desk.run("area().spaces.active.show_region_ui = True")
    desk.run("show_tab()")
    assert any("import_scan" in line for line in desk.panel())
    desk.shot("01_enabled")


@pytest.fixture
def state(desk):
    return desk.state


def test_preset_and_another_with_other_pixels(desk):
    desk.open_panel("preset", above="diffraction.import_scan")
    desk.choose("preset", "sinusoid")
    desk.enter("preset_size_um", 10)
    desk.enter("preset_pixels", 128)
    desk.press("diffraction.make_preset")
    assert "128 x 128" in desk.state("scan_info")
    desk.enter("preset_pixels", 96)
    desk.press("diffraction.make_preset")
    assert "96 x 96" in desk.state("scan_info")
    desk.choose("preset", "blazed")
    desk.enter("preset_pixels", 0)
    desk.press("diffraction.make_preset")
    assert "128 x 128" in desk.state("scan_info") and desk.state("scan_path").endswith("blazed.gsf")
    desk.shot("02_preset")
    assert desk.console() == []


def test_preview_shows_the_levelling_of_the_panel(desk):
    for level in ("plane", "none"):
        desk.choose("level", level)
        desk.press("diffraction.preview_levelling")
        assert desk.state("level") == level
        assert desk.look("'Diffraction Levelling' in bpy.data.images")
    desk.shot("03_preview")
    assert desk.console() == []


def test_bake_change_bake_again(desk):
    desk.enter("detail", "0.3")
    desk.press("diffraction.bake")
    first = json.loads(desk.state("table_recipe"))["settings"]
    assert first["detail"] == 0.3 and first["level"] == "none"
    desk.enter("sigma_s_um", "0.8")
    desk.press("diffraction.bake")
    second = json.loads(desk.state("table_recipe"))["settings"]
    assert second["sigma_s_um"] == 0.8
    assert desk.state("sigma_s_um") == pytest.approx(0.8)
    desk.shot("04_bake")
    assert desk.console() == []


def test_escape_stops_a_bake(desk):
    before = desk.state("table_recipe")
    desk.enter("detail", "2")
    desk.press("diffraction.bake", wait=False)
    desk.driver.key("ESC")
    desk.wait()
    assert desk.state("table_recipe") == before
    assert desk.state("detail") == 2.0
    desk.enter("detail", "0.3")
    assert desk.console() == []


def test_apply_then_other_fresnel(desk):
    desk.choose("implementation", "NODES")
    desk.press("diffraction.apply_material")
    node = "bpy.context.object.active_material.node_tree.nodes['Diffraction']"
    first = desk.look(f"{node}.inputs['Fresnel'].default_value")
    assert first == 2  # a blazed grating is metal
    desk.choose("fresnel", "DIELECTRIC")
    desk.press("diffraction.apply_material")
    assert desk.state("fresnel") == "DIELECTRIC"
    assert desk.look(f"{node}.inputs['Fresnel'].default_value") == 1
    desk.shot("05_apply")
    assert desk.console() == []
