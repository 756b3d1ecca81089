# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint of the active material: recipes with pictures, their settings, the button."""

from __future__ import annotations

import bpy

from .. import paint_properties
from ..materials import material
from ..materials.node import paint_nodes
from ..operators.painting.paint import active, without
from ..tables.table_state import READY, table_state
from .sidebar import Sidebar, note, number, split


class DIFFRACTION_PT_paint(Sidebar, bpy.types.Panel):
    """Recipes and pictures as maps of period, depth and direction"""

    bl_label = "Paint"
    bl_parent_id = "DIFFRACTION_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        shown = active(context)
        return material.is_ours(shown) and material.shader_node(shown) is not None

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction.paint
        if not bpy.app.background:
            layout.template_icon_view(state, "recipe", show_labels=True, scale=5.0, scale_popup=5.0)
        layout.prop(state, "recipe")
        values, hidden = getattr(state.recipes, state.recipe), without(state.recipe)
        for name in ("picture", "second_picture"):
            if name not in hidden:
                is_left = name == "picture" and "second_picture" not in hidden
                layout.prop(state, name, text="Left Picture" if is_left else state.bl_rna.properties[name].name)
        column = layout.column(align=True)
        for setting in paint_properties.settings(state.recipe):
            column.prop(values, setting.name)
        column = layout.column(align=True)
        number(column, state, "period_um", "table's")
        column.prop(state, "pixels")
        if "size_mm" not in hidden:
            column.prop(state, "size_mm")
        layout.operator("diffraction.paint", icon="BRUSH_DATA")
        shown = active(context)
        painted = paint_nodes.image(shown)
        if painted is not None:
            row = layout.row(align=True)
            row.label(text=painted.name, icon="IMAGE_DATA")
            row.operator("diffraction.remove_paint", text="", icon="X")
        found = table_state(material.table_path(shown))
        if found.kind == READY and found.info.get("stack") is not None:
            note(layout, "The table holds a stack: its colour is approximate where the paint scales it")


CLASSES = (DIFFRACTION_PT_paint,)
