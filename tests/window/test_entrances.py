# SPDX-License-Identifier: GPL-3.0-or-later
"""Where people look at the window: the search, the Import menu, a file dragged into the view, the command line."""

import os
import subprocess

import pytest

from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf


@pytest.fixture(scope="module")
def scan(work):
    """A scan alone in a folder."""
    path = work / "dropped" / "dropped.gsf"
    path.parent.mkdir()
    write_gsf(make_preset("sinusoid", 8e-6, 72), path)
    return path


@pytest.mark.parametrize(("preset", "label"), [("dvd", "DVD"), ("blazed", "Blazed")])
def test_search_runs_a_command_with_the_panels_values(enabled, preset, label):
    if preset == "dvd":
        enabled.new_file()
    enabled.run(f"bpy.context.scene.diffraction.preset = {preset!r}\nbpy.context.scene.diffraction.preset_pixels = 64")
    enabled.over_view()
    enabled.driver.key("F3")
    enabled.settle()
    enabled.driver.type("use preset")
    enabled.settle()
    enabled.shot(f"60_search_{preset}")
    enabled.driver.key("RET")
    enabled.settle()
    enabled.wait()
    assert preset in enabled.state("scan_path"), label
    assert enabled.console() == []


def test_scan_dragged_into_the_view(enabled, scan):
    enabled.new_file()
    enabled.run("editor = next(a for a in window().screen.areas if a.type == 'PROPERTIES')\neditor.ui_type = 'FILES'")
    enabled.settle()
    enabled.run(f"""
space = editor.spaces.active
space.show_region_toolbar = space.show_region_tool_props = False
space.params.directory = {str(scan.parent)!r}.encode()
space.params.display_type = 'THUMBNAIL'
""")
    enabled.watch(2.0)
    enabled.settle()
    x, y, _, height = enabled.look("rectangle('FILE_BROWSER', 'WINDOW')")
    left, bottom, wide, high = enabled.look("rectangle('VIEW_3D', 'WINDOW')")
    enabled.shot("61_file_browser")
    enabled.drag((x + 60, y + height - 60), (left + wide // 3, bottom + high // 2))
    enabled.settle()
    enabled.wait()
    enabled.shot("62_dropped")
    enabled.run("editor.ui_type = 'PROPERTIES'")
    assert "72 x 72 px" in enabled.state("scan_info")
    assert enabled.console() == []


def test_import_menu_shows_it(enabled):
    enabled.new_file()
    enabled.run("with anywhere(): bpy.ops.wm.call_menu(name='TOPBAR_MT_file_import')")
    enabled.settle()
    enabled.shot("63_import_menu")
    enabled.driver.key("ESC")
    enabled.run("with within('VIEW_3D', 'WINDOW'): bpy.ops.wm.call_menu(name='DIFFRACTION_MT_object')")
    enabled.settle()
    enabled.shot("64_object_menu")
    enabled.driver.key("ESC")
    assert enabled.console() == []


def test_command_line_of_blender(enabled, scan, work):
    blender = os.environ.get("BLENDER")
    if not blender:
        pytest.skip("a rig's Blender is started by its own script")
    enabled.run("with anywhere(): bpy.ops.wm.save_userpref()")  # as Blender does when it quits
    environment = {**os.environ, "BLENDER_USER_RESOURCES": str(work / "user")}
    words = [blender, "--command", "diffraction", "info", str(scan)]
    done = subprocess.run(words, capture_output=True, text=True, env=environment, timeout=300, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "72 x 72" in done.stdout
    missing = subprocess.run([*words[:-1], "no_such.gsf"], capture_output=True, text=True, env=environment, check=False)
    assert missing.returncode == 2 and "no_such.gsf" in missing.stderr
