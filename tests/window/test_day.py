# SPDX-License-Identifier: GPL-3.0-or-later
"""A working day at the window, each button pressed at least twice with other values in the panel."""

import json

import pytest


def test_install_from_disk_and_enable(enabled):
    assert any("import_scan" in line for line in enabled.panel())
    enabled.shot("01_enabled")
    enabled.console()


def test_preset_and_another_with_other_pixels(enabled):
    enabled.open_panel("preset", above="diffraction.import_scan")
    enabled.choose("preset", "sinusoid")
    enabled.enter("preset_size_um", 10)
    enabled.enter("preset_pixels", 128)
    enabled.press("diffraction.make_preset")
    assert "128 x 128" in enabled.state("scan_info")
    enabled.enter("preset_pixels", 96)
    enabled.press("diffraction.make_preset")
    assert "96 x 96" in enabled.state("scan_info")
    enabled.choose("preset", "blazed")
    enabled.enter("preset_pixels", 0)
    enabled.press("diffraction.make_preset")
    assert "128 x 128" in enabled.state("scan_info") and enabled.state("scan_path").endswith("blazed.gsf")
    enabled.shot("02_preset")
    assert enabled.console() == []


def test_preview_shows_the_levelling_of_the_panel(enabled):
    for level in ("plane", "none"):
        enabled.choose("level", level)
        enabled.press("diffraction.preview_levelling")
        assert enabled.state("level") == level
        assert enabled.look("'Diffraction Levelling' in bpy.data.images")
    enabled.shot("03_preview")
    assert enabled.console() == []


def test_bake_change_bake_again(enabled):
    enabled.enter("detail", "0.3")
    enabled.press("diffraction.bake")
    first = json.loads(enabled.state("table_recipe"))["settings"]
    assert first["detail"] == 0.3 and first["level"] == "none"
    enabled.enter("sigma_s_um", "0.8")
    enabled.press("diffraction.bake")
    second = json.loads(enabled.state("table_recipe"))["settings"]
    assert second["sigma_s_um"] == 0.8
    assert enabled.state("sigma_s_um") == pytest.approx(0.8)
    enabled.shot("04_bake")
    assert enabled.console() == []


def test_escape_stops_a_bake(enabled):
    before = enabled.state("table_recipe")
    enabled.enter("detail", "2")
    enabled.press("diffraction.bake", wait=False)
    enabled.driver.key("ESC")
    enabled.wait()
    assert enabled.state("table_recipe") == before
    assert enabled.state("detail") == 2.0
    enabled.enter("detail", "0.3")
    assert enabled.console() == []


def test_apply_then_other_fresnel(enabled):
    enabled.choose("implementation", "NODES")
    enabled.press("diffraction.apply_material")
    node = "bpy.context.object.active_material.node_tree.nodes['Diffraction']"
    first = enabled.look(f"{node}.inputs['Fresnel'].default_value")
    assert enabled.state("fresnel") == "CONDUCTOR"  # a blazed grating is metal
    enabled.choose("fresnel", "DIELECTRIC")
    enabled.press("diffraction.apply_material")
    assert enabled.state("fresnel") == "DIELECTRIC"
    assert enabled.look(f"{node}.inputs['Fresnel'].default_value") != first
    enabled.shot("05_apply")
    assert enabled.console() == []


def test_automatic_takes_osl_with_cycles_and_fits_when_the_engine_changes(enabled):
    if not enabled.has_osl():
        pytest.skip("this Blender was built without Open Shading Language")
    needs = "addon('materials.material').needs_osl(bpy.context.object.active_material)"
    enabled.run("before = bpy.context.scene.render.engine\nbpy.context.scene.render.engine = 'CYCLES'")
    enabled.choose("implementation", "AUTO")
    enabled.press("diffraction.apply_material")
    assert enabled.look(needs)
    enabled.run("bpy.context.scene.render.engine = before")
    enabled.settle()
    enabled.press("diffraction.fit_renderer")
    assert not enabled.look(needs)
    enabled.shot("06_fitted")
    assert enabled.console() == []
