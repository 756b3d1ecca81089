# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 1: where the heights come from."""

from __future__ import annotations

import json

import bpy

from ...precompute.presets import PRESETS, look_of
from .. import paths
from ..operators.setting_presets import DIFFRACTION_MT_structure_presets
from ..tables import scan_store
from .sidebar import Sidebar, Stage, button, file_name, note, number, split


class DIFFRACTION_PT_scan(Stage, bpy.types.Panel):
    """Where the heights come from"""

    bl_label = "Scan"
    bl_order = 1

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = self.layout, context.scene.diffraction
        row = layout.row(align=True)
        button(row, "diffraction.import_scan", icon="FILEBROWSER", text="Import...")
        row.menu("DIFFRACTION_MT_stored_scans", text="", icon="DOWNARROW_HLT")
        if not state.scan_path:
            note(layout, "Import a scan, or take a preset structure below")
            return
        box = layout.column(align=True)
        note(box, file_name(state.scan_path), "MESH_GRID")
        for line in state.scan_info.split(", "):
            box.label(text=line, icon="BLANK1")
        if len(json.loads(state.channels or "[]")) > 1:
            layout.operator_menu_enum("diffraction.choose_channel", "channel", text="Other Channels")
        if not paths.absolute(state.scan_path).is_file():
            note(layout, "The stored scan is missing; import it again", "ERROR")


class DIFFRACTION_MT_stored_scans(bpy.types.Menu):
    """Scans that were stored with this file"""

    bl_label = "Stored Scans"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        found = scan_store.stored_scans()
        for path in found:
            layout.operator("diffraction.use_stored_scan", text=path.stem, icon="MESH_GRID").name = path.stem
        if not found:
            layout.label(text="No scan is stored with this file yet")


class DIFFRACTION_PT_preset(Sidebar, bpy.types.Panel):
    """Structures that need no microscope"""

    bl_label = "Preset Structure"
    bl_parent_id = "DIFFRACTION_PT_scan"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        row = self.layout.row(align=True)
        row.menu(DIFFRACTION_MT_structure_presets.__name__, text="", icon="PRESET")
        row.operator("diffraction.structure_preset_add", text="", icon="ADD")

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        if not bpy.app.background:
            layout.template_icon_view(state, "preset", show_labels=True, scale=5.0, scale_popup=5.0)
        row = layout.row()
        row.use_property_split = False  # beside a label the names are cut off
        row.prop(state, "preset", text="")
        preset, values = PRESETS[state.preset], getattr(state.presets, state.preset)
        column = layout.column(align=True)
        for parameter in preset.parameters:
            column.prop(values, parameter.name)
        column = layout.column(align=True)
        number(column, state, "preset_size_um", "auto")
        number(column, state, "preset_pixels", "auto")
        chosen = button(layout, "diffraction.make_preset", icon="MOD_OCEAN")
        chosen.look = True
        chosen.preset, chosen.size_um, chosen.pixels = state.preset, state.preset_size_um, state.preset_pixels
        for parameter in preset.parameters:
            setattr(chosen, parameter.name, getattr(values, parameter.name))
        note(layout, f"Also sets: {look_of(state.preset).summary()}")
        note(layout, preset.source, "BOOKMARKS")


CLASSES = (DIFFRACTION_PT_scan, DIFFRACTION_MT_stored_scans, DIFFRACTION_PT_preset)
