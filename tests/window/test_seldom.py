# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that a day needs seldom, each pressed twice with other values: stored scans, channels, kept settings,
changed settings, paint, lost and broken tables, the cache."""

import json
import re

import numpy as np
import pytest

from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf
from tests.support import more_scan_files

MATERIAL = "bpy.context.object.active_material"
NODE = f"{MATERIAL}.node_tree.nodes['Diffraction']"
ICON = 0.93  # share of the sidebar's width where small buttons stand on the right


@pytest.fixture(scope="module")
def folder(work):
    """Two scans, and a file with two channels."""
    place = work / "seldom"
    place.mkdir()
    write_gsf(make_preset("sinusoid", 8e-6, 64), place / "one.gsf")
    write_gsf(make_preset("blazed", 6e-6, 48), place / "two.gsf")
    heights = 50e-9 * np.sin(np.arange(56) / 3.0) * np.ones((40, 1))
    (place / "channels.mdt").write_bytes(more_scan_files.mdt(heights, (7e-6, 5e-6)))
    return place


@pytest.fixture(scope="module")
def day(enabled, folder):
    """A saved file."""
    enabled.new_file()
    enabled.run(f"with anywhere(): bpy.ops.wm.save_as_mainfile(filepath={str(folder / 'seldom.blend')!r})")
    enabled.open_sidebar()
    enabled.console()
    yield enabled
    enabled.new_file()


def import_file(desk, path):
    desk.run(f"with within('VIEW_3D', 'WINDOW'): bpy.ops.diffraction.import_scan(filepath={str(path)!r})")


def test_stored_scans_come_back(day, folder):
    for name in ("one", "two"):
        import_file(day, folder / f"{name}.gsf")
    names = day.look("[p.stem for p in addon('tables.scan_store').stored_scans()]")
    for name, size in (("one", "64 x 64"), ("two", "48 x 48"), ("one", "64 x 64")):
        day.press(re.compile("DIFFRACTION_MT_stored_scans"), share=ICON)
        day.settle()
        day.shot("70_stored_scans")
        day.pick(names.index(name))
        assert size in day.state("scan_info") and day.state("scan_path").endswith(f"{name}.gsf")
    assert day.console() == []


def test_other_channels(day, folder):
    import_file(day, folder / "channels.mdt")
    channels = json.loads(day.state("channels"))
    assert len(channels) == 2
    told = []
    for number in (0, 1):
        day.press("diffraction.choose_channel")
        day.settle()
        day.shot("71_channels")
        day.pick(number)
        told.append(day.state("scan_info"))
    assert all("56 x 40" in text for text in told) and told[0] != told[1]
    assert day.console() == []


@pytest.mark.parametrize(
    ("add", "menu", "prop", "values"),
    [
        ("bake_preset_add", "DIFFRACTION_MT_bake_presets", "sigma_s_um", (0.7, 1.9)),
        ("structure_preset_add", "DIFFRACTION_MT_structure_presets", "preset_size_um", (11.0, 13.0)),
    ],
)
def test_settings_kept_under_a_name(day, add, menu, prop, values):
    names = ["first", "second"]
    for name, value in zip(names, values, strict=True):
        day.run(f"bpy.context.scene.diffraction.{prop} = {value}")
        day.press(f"diffraction.{add}", wait=False, share=ICON)
        day.settle()
        day.driver.key("A", ctrl=True)
        day.driver.type(name)
        day.shot(f"72_{add}")
        day.driver.key("RET")
        day.driver.key("RET")
        day.settle()
    day.run(f"bpy.context.scene.diffraction.{prop} = 5")
    for number in (0, 1):
        day.press(re.compile(menu), share=0.84, wait=False)
        day.settle()
        day.shot(f"73_{menu.lower()}")
        day.pick(number)
        assert day.state(prop) == pytest.approx(values[number])
    assert day.console() == []


@pytest.fixture(scope="module")
def painted(day, folder):
    """The cube with a blazed grating, in the saved file."""
    import_file(day, folder / "two.gsf")
    day.run("""
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.diffraction.bake(detail=0.2, sigma_s_um=1.0)
    bpy.ops.diffraction.apply_material(implementation='NODES')
""")
    day.open_sidebar()
    day.console()
    return day


def test_changed_settings_come_back(painted):
    bump = f"{MATERIAL}.cycles.use_bump_map_correction"
    for times in range(2):
        assert painted.look(bump) is False
        painted.open_panel("settings", above="diffraction.apply_material")
        painted.press("diffraction.restore_settings")
        assert painted.look(bump) is True
        if times == 0:
            painted.shot("74_restored")
            painted.press("diffraction.apply_material")
    painted.press("diffraction.apply_material")
    assert painted.console() == []


def test_paint_and_its_undo(painted):
    painted.open_panel("paint", above="diffraction.apply_material")
    before = painted.look(f"{NODE}.inputs['Scale'].is_linked")
    sides = []
    for recipe, side in (("rings", 128), ("guilloche", 256)):
        painted.choose("recipe", recipe, owner="bpy.context.scene.diffraction.paint")
        painted.run(f"bpy.context.scene.diffraction.paint.pixels = {side}")
        painted.press("diffraction.paint")
        painted.shot(f"75_paint_{recipe}")
        assert painted.look(f"{NODE}.inputs['Scale'].is_linked")
        sides.append(painted.look("max(i.size[0] for i in bpy.data.images if 'paint' in i.name.lower())"))
        if recipe == "rings":
            painted.over_view()
            painted.driver.key("Z", ctrl=True)
            painted.settle()
            assert painted.look(f"{NODE}.inputs['Scale'].is_linked") is before
            painted.open_sidebar()
    assert sides == [128, 256]
    painted.press("diffraction.remove_paint", share=ICON)
    assert painted.look(f"{NODE}.inputs['Scale'].is_linked") is False
    assert painted.console() == []


def test_broken_table_is_baked_again(painted):
    table = "bpy.path.abspath(bpy.context.scene.diffraction.table_path)"
    kind = f"addon('tables.table_state').table_state(addon('materials.material').table_path({MATERIAL})).kind"
    for times in range(2):
        painted.run(f"open({table}, 'wb').write(b'no table')\nopen({table}[:-3] + 'json', 'w').write('no sidecar')")
        painted.settle()
        painted.open_sidebar()
        assert painted.look(kind) == "DAMAGED"
        painted.shot(f"76_broken_{times}")
        painted.press("diffraction.rebake")
        assert painted.look(kind) == "READY"
    assert painted.console() == []


def test_lost_tables_are_found_and_collected(painted, folder):
    table = painted.look("bpy.path.abspath(bpy.context.scene.diffraction.table_path)")
    kind = f"addon('tables.table_state').table_state(addon('materials.material').table_path({MATERIAL})).kind"
    for times in range(2):
        away = folder / f"away_{times}"
        away.mkdir()
        here = painted.look(f"addon('materials.travel').home({MATERIAL}).as_posix()")
        painted.run(f"""
import shutil
from pathlib import Path
for each in Path({here!r}).parent.glob(Path({here!r}).stem + '.*'): shutil.move(each, {str(away)!r})
""")
        painted.settle()
        painted.open_sidebar()
        assert painted.look(kind) == "MISSING"
        painted.open_panel("files", above="diffraction.apply_material")
        painted.browse("diffraction.find_files", away)
        assert painted.look(kind) == "READY"
        assert str(away) in painted.look(f"addon('materials.travel').home({MATERIAL}).as_posix()")
        painted.shot(f"77_found_{times}")
        painted.press("diffraction.collect_files")
        assert painted.look(f"addon('materials.travel').home({MATERIAL}).as_posix()") == table
        assert painted.look(kind) == "READY"
    assert painted.console() == []


def test_cache_is_cleared(painted):
    size = "addon('preferences')._held().size_bytes()"
    painted.run("""
with anywhere(): bpy.ops.screen.userpref_show()
bpy.context.preferences.active_section = 'ADDONS'
bpy.context.window_manager.addon_search = 'Diffraction'
""")
    painted.settle()
    number = painted.look("len(bpy.context.window_manager.windows)") - 1
    where = ("PREFERENCES", "WINDOW", number)
    for sigma in (1.1, 1.2):
        painted.run(f"with within('VIEW_3D', 'WINDOW'): bpy.ops.diffraction.bake(detail=0.2, sigma_s_um={sigma})")
        painted.run("with anywhere(): bpy.ops.preferences.addon_show(module='bl_ext.user_default.diffraction_shader')")
        painted.settle()
        assert painted.look(size) > 0
        painted.shot("78_preferences")
        painted.press("diffraction.clear_cache", where=where, share=0.8)
        assert painted.look(size) == 0
    painted.close_windows()
    assert painted.console() == []
