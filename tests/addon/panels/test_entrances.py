# SPDX-License-Identifier: GPL-3.0-or-later
"""Where people look: menus, dropped files, the material's tab, the shader editor, the manual, the command line."""

import fnmatch
import json
import re

import bpy
import pytest

from tests.support.blender import scenes

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def plane(blender, tmp_path):
    """A selected plane in a saved file whose scene has a table."""
    return scenes.plane_with_table(tmp_path)


def menu_text(draw, context=None):
    layout = bpy.context.window_manager.popmenu_begin__internal("test").layout
    draw(type("Menu", (), {"layout": layout})(), context or bpy.context)
    return json.dumps(layout.introspect(), default=str)


def test_menus_offer_it():
    from diffraction_shader.addon.panels import entrances

    assert "diffraction.import_scan" in menu_text(entrances._import)
    editor = type("Context", (), {"space_data": type("S", (), {"type": "NODE_EDITOR", "tree_type": "ShaderNodeTree"})})
    assert "Nodes of this extension" in menu_text(entrances._add_node, editor)
    ours = menu_text(entrances.DIFFRACTION_MT_add.draw, editor)
    assert "diffraction.add_node" in ours and "Snake Scales" in ours
    geometry = type("Context", (), {"space_data": type("S", (), {"type": "NODE_EDITOR", "tree_type": "Other"})})
    assert "Nodes of this extension" not in menu_text(entrances._add_node, geometry)
    assert entrances._import in bpy.types.TOPBAR_MT_file_import.draw._draw_funcs
    assert entrances._add_node in bpy.types.NODE_MT_shader_node_add_all.draw._draw_funcs


def test_dropped_scans_are_taken_and_pictures_left_to_blender():
    from diffraction_shader.addon.panels.entrances import dropped_extensions

    endings = dropped_extensions().split(";")
    assert {".gsf", ".gwy", ".spm"} <= set(endings)
    assert not {".png", ".jpg", ".tif", ".exr"} & set(endings)
    handler = bpy.types.DIFFRACTION_FH_scan
    assert handler.bl_import_operator == "diffraction.import_scan"
    view = type("C", (), {"area": type("A", (), {"type": "VIEW_3D"})})
    text = type("C", (), {"area": type("A", (), {"type": "TEXT_EDITOR"})})
    assert handler.poll_drop(view) and not handler.poll_drop(text)
    # Blender fills in the file and must not remember it.
    assert bpy.ops.diffraction.import_scan.get_rna_type().properties["filepath"].is_skip_save


def test_every_operator_and_property_has_a_page(root_dir):
    from diffraction_shader.addon.panels.entrances import manual

    prefix, pages = manual()
    names = [f"bpy.ops.diffraction.{name}" for name in dir(bpy.ops.diffraction)]
    names += [f"bpy.types.DIFFRACTION_PG_scene.{p.identifier}" for p in bpy.context.scene.diffraction.bl_rna.properties]
    for name in names:
        page = next(page for pattern, page in pages if fnmatch.fnmatchcase(name.lower(), pattern))
        assert (root_dir / "docs" / "guide" / page).is_file()
    assert prefix.startswith("file://") and prefix.endswith("/")


def test_the_manual_that_ships(tmp_path):
    from tools.build import manual

    manual.write(tmp_path)
    assert sorted(path.name for path in tmp_path.glob("*.html")) == ["parameters.html", "scripting.html", "user.html"]
    for page in tmp_path.glob("*.html"):
        text = page.read_text(encoding="utf-8")
        for target in re.findall(r'(?:href|src)="([^"#]+)', text):
            assert target.startswith("http") or (tmp_path / target).is_file(), target
    assert sum(path.stat().st_size for path in tmp_path.rglob("*") if path.is_file()) < 1e6


def test_the_command_line_is_that_of_the_core(capsys):
    from diffraction_shader.addon.panels.entrances import command

    assert command(["--help"]) == 0 and "bake" in capsys.readouterr().out
    assert command(["info", "no such file.gsf"]) == 2
    assert "no file" in capsys.readouterr().err


def test_the_search_finds_every_command_of_the_panels(plane):
    """F3 reads menus. What is left out needs something that only its button knows."""
    from diffraction_shader.addon.panels import entrances

    of_buttons = {
        "choose_channel",
        "use_stored_scan",
        "show_image",
        "bake_preset_add",
        "structure_preset_add",
        "add_node",
        "add_snake_scales",
    }
    assert set(entrances.COMMANDS) - {None} | of_buttons >= {name for name in dir(bpy.ops.diffraction)}
    text = menu_text(bpy.types.DIFFRACTION_MT_object.draw, bpy.context)
    assert all(f"diffraction.{name}" in text for name in entrances.COMMANDS if name)
    assert entrances._object in bpy.types.VIEW3D_MT_object.draw._draw_funcs


def test_the_material_tab_leads_on(plane):
    tab = bpy.types.DIFFRACTION_PT_material_tab
    context = type("C", (), {"scene": bpy.context.scene, "object": plane, "material": None})
    assert tab.poll(context)
    assert "diffraction.apply_material" in menu_text(tab.draw, context)
    bpy.context.scene.diffraction.table_path = ""
    assert "sidebar" in menu_text(tab.draw, context)


def test_the_shader_editor_adds_it_to_what_it_shows(plane):
    from diffraction_shader.addon.operators.add_node import DIFFRACTION_OT_add_node as operator

    assert not bpy.ops.diffraction.add_node.poll()
    paint = bpy.data.materials.new("paint")
    if paint.node_tree is None:
        paint.use_nodes = True
    told = []
    space = type("S", (), {"type": "NODE_EDITOR", "id": paint})
    context = type("C", (), {"scene": bpy.context.scene, "space_data": space})
    person = type("O", (), {"report": lambda self, kind, text: told.append(text)})()
    assert operator.execute(person, context) == {"FINISHED"}
    node = paint.node_tree.nodes["Diffraction"]
    assert node.inputs["Base"].is_linked and paint.node_tree.nodes.active == node
    assert "paint diffracts" in told[0]


def test_pictures_of_presets_are_small_and_whole(root_dir):
    from precompute.presets import PRESETS

    folder = root_dir / "addon" / "preset_pictures"
    assert {path.stem for path in folder.glob("*.png")} == set(PRESETS)
    assert all(path.stat().st_size < 20_000 for path in folder.glob("*.png"))
    items = bpy.context.scene.diffraction.bl_rna.properties["preset"].enum_items
    assert [item.identifier for item in items] == list(PRESETS)
