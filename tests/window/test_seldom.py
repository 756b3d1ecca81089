# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons that a day needs seldom, each pressed twice: stored scans, changed settings, paint, lost and broken tables,
the cache."""

import re

import pytest

from precompute.presets import make_preset
from precompute.scan.gsf import write_gsf

MATERIAL = "bpy.context.object.active_material"
NODE = f"{MATERIAL}.node_tree.nodes['Diffraction']"


@pytest.fixture(scope="module")
def folder(work):
    """Two scans."""
    place = work / "seldom"
    place.mkdir()
    write_gsf(make_preset("sinusoid", 8e-6, 64), place / "one.gsf")
    write_gsf(make_preset("blazed", 6e-6, 48), place / "two.gsf")
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
        day.press_near("diffraction.import_scan", 0.82)
        day.shot("70_stored_scans")
        day.pick(names.index(name))
        assert size in day.state("scan_info") and day.state("scan_path").endswith(f"{name}.gsf")
    assert day.console() == []


@pytest.fixture(scope="module")
def painted(day, folder):
    """The cube with a blazed grating, in the saved file."""
    import_file(day, folder / "two.gsf")
    day.run("""
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.diffraction.bake(detail=0.2, sigma_s_um=1.0)
    bpy.ops.diffraction.apply_material(implementation='NODES')
    bpy.ops.ed.undo_push(message='Apply')  # as a click does
""")
    day.open_sidebar()
    day.console()
    return day


def test_changed_settings_come_back(painted):
    bump = f"{MATERIAL}.cycles.use_bump_map_correction"
    for times in range(2):
        assert painted.look(bump) is False
        with painted.only("material", "settings"):
            painted.press("diffraction.restore_settings")
            painted.shot("74_changed_settings")
        assert painted.look(bump) is True
        if times == 1:
            painted.run("bpy.context.scene.diffraction.rotation = 0.2")
        painted.press("diffraction.apply_material")
    assert painted.console() == []


def test_paint_and_its_undo(painted):
    linked = f"{NODE}.inputs['Scale'].is_linked"
    with painted.only("material", "paint"):
        assert painted.look(linked) is False
        for recipe, side in (("rings", 128), ("guilloche", 256)):
            painted.run(f"bpy.context.scene.diffraction.paint.recipe = {recipe!r}")
            painted.run(f"bpy.context.scene.diffraction.paint.pixels = {side}")
            painted.press(re.compile(r"ops\.diffraction\.paint\("))
            painted.shot(f"75_paint_{recipe}")
            assert painted.look(linked)
            sizes = painted.look(f"[i.size[0] for i in bpy.data.images if '.{recipe}.' in i.name]")
            assert sizes == [side]
            if recipe == "rings":
                painted.over_view()
                painted.driver.key("Z", ctrl=True)
                painted.settle()
                assert painted.look(linked) is False
        painted.press("diffraction.remove_paint", share=0.83)
        assert painted.look(linked) is False
    # A Blender with an OpenEXR of its own prints this as ours writes ZIP.
    assert [line for line in painted.console() if "EXR_ERR_ARGUMENT_OUT_OF_RANGE" not in line] == []


def test_broken_table_is_baked_again(painted):
    table = "bpy.path.abspath(bpy.context.scene.diffraction.table_path)"
    kind = f"addon('tables.table_state').table_state(addon('materials.material').table_path({MATERIAL})).kind"
    for times in range(2):
        painted.run(f"open({table}, 'wb').write(b'no table')\nopen({table}[:-3] + 'json', 'w').write('no sidecar')")
        painted.settle()
        painted.open_sidebar()
        assert painted.look(kind) == "DAMAGED"
        with painted.only("material", "active"):
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
for each in Path({here!r}).parent.glob(Path({here!r}).stem + '.*'):
    if each.suffix != '.gsf': shutil.move(each, {str(away)!r})
""")
        painted.settle()
        painted.open_sidebar()
        assert painted.look(kind) == "MISSING"
        with painted.only("material", "files"):
            painted.shot(f"77_lost_{times}")
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
