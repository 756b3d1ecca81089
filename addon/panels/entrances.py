# SPDX-License-Identifier: GPL-3.0-or-later
"""Where people look for it: the menus File > Import and Object > Diffraction, which the search (F3) reads, files
dropped onto the 3-D view, the shader editor, *Online Manual* on right-click, and `blender -c diffraction`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import bpy

from ...precompute.presets import PRESETS
from ...precompute.readers.formats import FORMATS
from ..paths import manual_page
from ..watch import report


def dropped_extensions() -> str:
    """Endings of scans, for Blender's file handlers; pictures stay with Blender, which makes references of them."""
    endings = {ending for each in FORMATS if not each.plain for ending in each.extensions}
    return ";".join(sorted(endings - _OF_BLENDER))


#: Pictures and tables that Blender itself takes when they are dropped.
_OF_BLENDER = {
    ".png",
    ".jpg",
    ".jpeg",
    ".bmp",
    ".tif",
    ".tiff",
    ".exr",
    ".hdr",
    ".webp",
    ".csv",
    ".stl",
    ".ply",
    ".obj",
}


class DIFFRACTION_FH_scan(bpy.types.FileHandler):
    """Scans dropped onto the 3-D view"""

    bl_idname = "DIFFRACTION_FH_scan"
    bl_label = "Surface Scan"
    bl_import_operator = "diffraction.import_scan"
    bl_file_extensions = dropped_extensions()

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        return context.area is not None and context.area.type == "VIEW_3D"


def _import(self: Any, context: bpy.types.Context) -> None:
    self.layout.operator("diffraction.import_scan", text="Surface Scan (AFM, profiler)", icon="MESH_GRID")


#: What the menu lists and the search therefore finds, by the panel's order; None stands for a line.
COMMANDS = (
    "import_scan", "make_preset", "preview_levelling", "coherence_of_sunlight", None,
    "bake", "apply_material", "paint", "remove_paint", "fit_renderer", "make_local", "restore_settings",
    "bake_lights", None,
    "viewport_render", "brdf_map", "reflectance", None,
    "use_material_scan", "rebake", "check_files", "find_files", "collect_files", "pack", "unpack", None,
    "make_asset_library", "clear_cache",
)  # fmt: skip


class DIFFRACTION_MT_object(bpy.types.Menu):
    """All that the tab Diffraction does"""

    bl_label = "Diffraction"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        for name in COMMANDS:
            if name is None:
                layout.separator()
            else:
                layout.operator(f"diffraction.{name}")


def _object(self: Any, context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(DIFFRACTION_MT_object.__name__)


def _add_node(self: Any, context: bpy.types.Context) -> None:
    if context.space_data.type == "NODE_EDITOR" and context.space_data.tree_type == "ShaderNodeTree":
        self.layout.separator()
        self.layout.menu("DIFFRACTION_MT_add", icon="MATERIAL")


class DIFFRACTION_MT_add(bpy.types.Menu):
    """Nodes of this extension"""

    bl_idname = "DIFFRACTION_MT_add"
    bl_label = "Diffraction"

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.operator("diffraction.add_node", text="Diffraction")
        self.layout.operator_context = "INVOKE_DEFAULT"
        self.layout.operator_menu_enum("diffraction.add_snake_scales", "species", text="Snake Scales")


#: Pages of the guide by patterns of what Blender calls a button: operators, and properties of the scene.
_PAGES = (
    ("bpy.types.DIFFRACTION_PG_scene.preset*", "user"),
    *((f"bpy.types.DIFFRACTION_PG_preset_{name}.*", "parameters") for name in PRESETS),
    ("bpy.types.DIFFRACTION_PG*", "parameters"),
    ("bpy.types.diffraction*", "parameters"),
    ("bpy.ops.diffraction.*", "user"),
)


def manual() -> tuple[str, list[tuple[str, str]]]:
    """Blender's hook: the guide that lies with the extension."""
    folder, ending = Path(manual_page("")), "html"
    if not folder.is_dir():  # a checkout
        folder, ending = folder.with_name("docs") / "guide", "md"
    return folder.as_uri() + "/", [(pattern.lower(), f"{page}.{ending}") for pattern, page in _PAGES]


def command(arguments: list[str]) -> int:
    """``blender -c diffraction ...``: as ``python -m precompute ...``, and ``check`` takes .blend files too."""
    from ...precompute.cli import EXIT_ERROR, EXIT_FAULTS, main

    files = arguments[1:]
    if arguments[:1] != ["check"] or not files or not all(each.endswith(".blend") for each in files):
        return main(arguments)
    code = 0
    for each in files:
        try:
            bpy.ops.wm.open_mainfile(filepath=each, use_scripts=False)
        except RuntimeError as error:
            print(str(error).strip(), file=sys.stderr)
            return EXIT_ERROR
        for scene in bpy.data.scenes:
            for text in report.before_render(scene):
                print(f"{each}: {scene.name}: {text}")
                code = EXIT_FAULTS
    return code


_MENUS = (("TOPBAR_MT_file_import", _import), ("VIEW3D_MT_object", _object), ("NODE_MT_shader_node_add_all", _add_node))

_command = None


def register() -> None:
    """Hang everything on."""
    global _command
    for name, draw in _MENUS:
        menu = getattr(bpy.types, name, None)
        if menu is not None:
            menu.append(draw)
    bpy.utils.register_manual_map(manual)
    if _command is None:
        _command = bpy.utils.register_cli_command("diffraction", command)


def unregister() -> None:
    """Take it off."""
    global _command
    for name, draw in _MENUS:
        menu = getattr(bpy.types, name, None)
        if menu is not None:
            menu.remove(draw)
    bpy.utils.unregister_manual_map(manual)
    if _command is not None:
        bpy.utils.unregister_cli_command(_command)
        _command = None


CLASSES = (DIFFRACTION_FH_scan, DIFFRACTION_MT_object, DIFFRACTION_MT_add)
