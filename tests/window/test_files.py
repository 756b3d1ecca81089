# SPDX-License-Identifier: GPL-3.0-or-later
"""Files at the window: scans by the browser, undo, save, open, new, second windows, disable and enable."""

import json

import numpy as np
import pytest

from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf


@pytest.fixture(scope="module")
def scans(work):
    """Two scans and a picture without units, where Blender sees them."""
    from PIL import Image

    folder = work / "scans"
    folder.mkdir()
    write_gsf(make_preset("sinusoid", 8e-6, 64), folder / "one.gsf")
    write_gsf(make_preset("blazed", 6e-6, 48), folder / "two.gsf")
    heights = np.random.default_rng(1).uniform(0, 65535, (96, 96)).astype(np.uint16)
    Image.fromarray(heights).save(folder / "picture.png")
    return folder


def test_import_another_a_picture_and_cancel(enabled, scans):
    enabled.new_file()
    enabled.console()
    assert enabled.browse("diffraction.import_scan", scans / "one.gsf") == {"size_um": [0.0, 0.0], "height_nm": 0.0}
    assert "64 x 64 px, 8 x 8 um" in enabled.state("scan_info")
    enabled.browse("diffraction.import_scan", scans / "two.gsf")  # the browser opens the second time, too
    assert "48 x 48 px, 6 x 6 um" in enabled.state("scan_info")
    enabled.browse("diffraction.import_scan", scans / "picture.png", size_um=(8.1, 8.1), height_nm=118.0)
    assert "96 x 96 px, 8.1 x 8.1 um" in enabled.state("scan_info")
    # What belongs to the picture does not stick to the next file.
    assert enabled.browse("diffraction.import_scan", scans / "one.gsf") == {"size_um": [0.0, 0.0], "height_nm": 0.0}
    assert "64 x 64 px, 8 x 8 um" in enabled.state("scan_info")
    before = enabled.state("scan_path")
    enabled.browse("diffraction.import_scan", None)
    assert enabled.state("scan_path") == before
    # The browser begins where the last scan was.
    assert enabled.last_folder.rstrip("/") == str(scans)
    enabled.shot("10_import")
    assert enabled.console() == []


def test_import_while_a_browser_is_open(enabled, scans):
    before = enabled.state("scan_path")
    enabled.press("diffraction.import_scan", wait=False)
    enabled.settle()
    enabled.browse("diffraction.import_scan", scans / "two.gsf", already=True)
    assert enabled.state("scan_path") != before and "48 x 48 px" in enabled.state("scan_info")
    enabled.close_windows()
    enabled.browse("diffraction.import_scan", scans / "one.gsf")
    assert "64 x 64 px" in enabled.state("scan_info")
    assert enabled.console() == []


def test_undo_and_redo_of_a_preset(enabled):
    first = enabled.state("scan_info")
    enabled.open_panel("preset", above="diffraction.import_scan")
    enabled.enter("preset_size_um", 12)
    enabled.enter("preset_pixels", 72)
    enabled.press("diffraction.make_preset")
    assert "72 x 72" in enabled.state("scan_info")
    enabled.over_view()
    enabled.driver.key("Z", ctrl=True)
    enabled.settle()
    assert enabled.state("scan_info") == first
    enabled.driver.key("Z", ctrl=True, shift=True)
    enabled.settle()
    assert "72 x 72" in enabled.state("scan_info")
    enabled.driver.key("Z", ctrl=True)
    enabled.settle()
    assert enabled.state("scan_info") == first
    enabled.enter("preset_pixels", 60)  # once more after undo, with another value
    enabled.press("diffraction.make_preset")
    assert "60 x 60" in enabled.state("scan_info")
    assert enabled.console() == []


def test_apply_to_several_a_curve_an_empty_and_nothing(enabled):
    enabled.enter("detail", "0.2")
    enabled.press("diffraction.bake")
    enabled.run("""
bpy.ops.object.select_all(action='DESELECT')
for kind in ('primitive_cube_add', 'primitive_plane_add'):
    with within('VIEW_3D', 'WINDOW'): getattr(bpy.ops.mesh, kind)(location=(3, 0, 0))
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.curve.primitive_bezier_circle_add(location=(-3, 0, 0))
    bpy.context.object.name = 'Curve'  # its name is translated
    bpy.context.object.data.bevel_depth = 0.3
    bpy.ops.object.empty_add(location=(0, 3, 0))
for ob in bpy.context.scene.objects: ob.select_set(ob.name in {'Cube.001', 'Plane', 'Curve', 'Empty'})
""")
    enabled.press("diffraction.apply_material")
    names = ("Cube.001", "Plane", "Curve")
    ours = "[bool(m and 'Diffraction' in m.node_tree.nodes) for m in (bpy.data.objects[n].active_material for n in {})]"
    assert enabled.look(ours.format(names)) == [True, True, True]
    count = enabled.look("len(bpy.data.materials)")
    for chosen in ("Empty", ""):
        enabled.run(f"for ob in bpy.context.scene.objects: ob.select_set(ob.name == {chosen!r})")
        enabled.press("diffraction.apply_material")  # grey
        assert enabled.look("len(bpy.data.materials)") == count
    enabled.shot("11_apply_to_many")
    assert enabled.console() == []


def test_save_open_and_bake_again(enabled, work):
    enabled.run(f"with anywhere(): bpy.ops.wm.save_as_mainfile(filepath={str(work / 'day.blend')!r})")
    enabled.enter("sigma_s_um", "0.6")
    enabled.press("diffraction.bake")
    enabled.run("with anywhere(): bpy.ops.wm.save_mainfile()")
    enabled.run(f"with anywhere(): bpy.ops.wm.open_mainfile(filepath={str(work / 'day.blend')!r})")
    enabled.open_sidebar()
    assert enabled.state("sigma_s_um") == pytest.approx(0.6)
    enabled.enter("sigma_s_um", "0.9")
    enabled.press("diffraction.bake")
    assert json.loads(enabled.state("table_recipe"))["settings"]["sigma_s_um"] == 0.9
    assert enabled.state("sigma_s_um") == pytest.approx(0.9)
    assert enabled.console() == []


def test_new_file_takes_the_new_panel(enabled):
    enabled.new_file()
    enabled.open_panel("preset", above="diffraction.import_scan")
    enabled.enter("preset_pixels", 64)
    enabled.press("diffraction.make_preset")
    assert "64 x 64 px" in enabled.state("scan_info") and enabled.state("orientation") == "RADIAL"
    assert enabled.console() == []


def test_second_window_and_quad_view(enabled):
    enabled.run("with anywhere(): bpy.ops.wm.window_new()")
    enabled.run("with within('VIEW_3D', 'WINDOW'): bpy.ops.screen.region_quadview()")
    enabled.settle()
    enabled.run("bpy.context.scene.diffraction.preset_size_um = 12")
    enabled.press("diffraction.make_preset")
    enabled.shot("12_two_windows")
    enabled.run("bpy.context.scene.diffraction.sigma_s_um = 1.0")  # quick, where numpy has no library of its own
    enabled.press("diffraction.bake")
    enabled.press("diffraction.apply_material")
    enabled.close_windows()
    enabled.shot("13_quad_view")
    enabled.press("diffraction.viewport_render")  # draws the quarter that was used last
    assert enabled.image("Viewport Picture").std() > 0.0
    enabled.close_windows()
    enabled.run("with within('VIEW_3D', 'WINDOW'): bpy.ops.screen.region_quadview()")
    assert enabled.console() == []


def test_disable_and_enable(enabled):
    name = "bl_ext.user_default.diffraction_shader"
    enabled.run("bpy.context.scene.diffraction.sigma_s_um = 8.0")
    enabled.press("diffraction.bake", wait=False)
    assert enabled.look("busy()")
    enabled.run(f"bpy.ops.preferences.addon_disable(module={name!r})")
    enabled.settle()
    assert enabled.look("hasattr(bpy.types.Scene, 'diffraction')") is False
    enabled.run(f"bpy.ops.preferences.addon_enable(module={name!r})")
    enabled.open_sidebar()
    assert any("import_scan" in line for line in enabled.panel())
    assert enabled.look("hasattr(bpy.types.Scene, 'diffraction')")
    assert not enabled.look("busy()")  # its bake has ended with it
    assert enabled.console() == []
