# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset library: its button; materials of it appended, linked, and dragged onto an object."""

import pytest

MATERIAL = "bpy.data.objects['Cube'].active_material"


@pytest.fixture(scope="module")
def library(enabled):
    """Begun by the button and stopped by Esc, since all materials take long; then two of them, in the same way."""
    enabled.new_file()
    enabled.console()
    enabled.open_panel("assets", above="diffraction.apply_material")
    enabled.press("diffraction.make_asset_library", wait=False)
    enabled.watch(10.0)
    enabled.shot("50_library_in_work")
    assert enabled.look("busy()")
    enabled.over_view()
    enabled.driver.key("ESC")
    enabled.wait()
    call = "bpy.ops.diffraction.make_asset_library('INVOKE_DEFAULT', only='blazed, cd')"
    enabled.run(f"with within('VIEW_3D', 'WINDOW'): {call}")
    enabled.settle()
    enabled.wait(1800.0)
    libraries = "bpy.context.preferences.filepaths.asset_libraries"
    (folder,) = enabled.look(f"[each.path for each in {libraries} if each.name == 'Diffraction']")
    place = f"{folder}/materials.blend"
    enabled.run(
        f"with bpy.data.libraries.load({place!r}, assets_only=True) as (there, _): found = list(there.materials)"
    )
    assert len(enabled.look("found")) == 2
    assert enabled.console() == []
    return folder


@pytest.mark.parametrize("link", [False, True])
def test_append_and_link(enabled, library, link):
    enabled.new_file()
    folder = library + "/materials.blend/Material/"
    enabled.run(f"""
with anywhere(): bpy.ops.wm.append(directory={folder!r}, filename='Blazed Grating 400/mm', link={link})
bpy.data.objects['Cube'].active_material = bpy.data.materials['Blazed Grating 400/mm']
""")
    enabled.settle()
    assert table_is_ready(enabled)
    assert enabled.look(f"{MATERIAL}.library is not None") is link
    enabled.shot(f"51_{'linked' if link else 'appended'}")
    if link:
        enabled.press("diffraction.make_local")
        assert enabled.look(f"{MATERIAL}.is_editable") and table_is_ready(enabled)
        enabled.shot("51_made_local")
    assert enabled.console() == []


def test_drag_from_the_asset_browser(enabled, library):
    enabled.new_file()
    enabled.run("""
editor = next(a for a in window().screen.areas if a.type == 'PROPERTIES')
editor.ui_type = 'ASSETS'
""")
    enabled.settle()
    enabled.run("""
space = editor.spaces.active
space.show_region_toolbar = space.show_region_tool_props = False
space.params.asset_library_reference = 'Diffraction'
space.params.catalog_id = ''
""")
    enabled.watch(5.0)
    x, y, _, height = enabled.look("rectangle('FILE_BROWSER', 'WINDOW')")
    begin = x + 60, y + height - 60
    cube = enabled.look("""(lambda r, d: [int(v) for v in __import__('bpy_extras.view3d_utils', fromlist=['x'])
        .location_3d_to_region_2d(r, d, (0, 0, 0))])(region('VIEW_3D', 'WINDOW'), area().spaces.active.region_3d)""")
    left, bottom = enabled.look("rectangle('VIEW_3D', 'WINDOW')")[:2]
    enabled.shot("52_asset_browser")
    enabled.drag(begin, (left + cube[0], bottom + cube[1]))
    enabled.settle()
    enabled.shot("53_dragged")
    assert enabled.look(f"'Diffraction' in {MATERIAL}.node_tree.nodes")
    assert table_is_ready(enabled)
    enabled.open_sidebar()
    if not enabled.look(f"{MATERIAL}.is_editable"):
        enabled.press("diffraction.make_local")
    assert enabled.look(f"{MATERIAL}.is_editable") and table_is_ready(enabled)
    enabled.run("editor.ui_type = 'PROPERTIES'")
    assert enabled.console() == []


def table_is_ready(desk):
    """Whether the cube's material finds its table."""
    return (
        desk.look(f"addon('tables.table_state').table_state(addon('materials.material').table_path({MATERIAL})).kind")
        == "READY"
    )
