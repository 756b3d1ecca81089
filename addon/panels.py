# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel in the 3-D view's sidebar, from scan to material."""

from __future__ import annotations

import bpy

from . import material


class _Sidebar:
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Diffraction"


class DIFFRACTION_PT_main(_Sidebar, bpy.types.Panel):
    """Scan, table and material of the scene"""

    bl_label = "Diffraction"

    def draw(self, context):
        if context.scene.diffraction.message:
            self.layout.label(text=context.scene.diffraction.message, icon="ERROR")


class DIFFRACTION_PT_scan(_Sidebar, bpy.types.Panel):
    """Where the heights come from"""

    bl_label = "Scan"
    bl_parent_id = "DIFFRACTION_PT_main"

    def draw(self, context):
        layout, state = self.layout, context.scene.diffraction
        row = layout.row(align=True)
        row.operator("diffraction.import_scan", icon="FILEBROWSER", text="Import...")
        row.operator_menu_enum("diffraction.make_preset", "preset", text="Preset")
        if state.scan_path:
            layout.label(text=bpy.path.basename(state.scan_path.replace("//", "")), icon="MESH_GRID")
            layout.label(text=state.scan_info)


class DIFFRACTION_PT_bake(_Sidebar, bpy.types.Panel):
    """From the heights to a table of colours"""

    bl_label = "Table"
    bl_parent_id = "DIFFRACTION_PT_main"

    def draw(self, context):
        layout, state = self.layout, context.scene.diffraction
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.enabled = state.progress < 0.0
        column.prop(state, "level")
        column.prop(state, "clip_percent")
        column.prop(state, "ensemble")
        column.prop(state, "sigma_s_um")
        if state.progress >= 0.0:
            layout.progress(factor=state.progress, text=f"{state.progress_text}, Esc stops")
        else:
            layout.operator("diffraction.bake", icon="RENDER_STILL")
        if state.table_path:
            layout.label(text=bpy.path.basename(state.table_path.replace("//", "")), icon="CHECKMARK")
            layout.label(text=state.table_info)


class DIFFRACTION_PT_bake_advanced(_Sidebar, bpy.types.Panel):
    """Less needed options of the bake"""

    bl_label = "Advanced"
    bl_parent_id = "DIFFRACTION_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, state = self.layout, context.scene.diffraction
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in ("series", "tolerance", "illuminant", "limit_mb"):
            layout.prop(state, name)


class DIFFRACTION_PT_material(_Sidebar, bpy.types.Panel):
    """From the table to the surfaces"""

    bl_label = "Material"
    bl_parent_id = "DIFFRACTION_PT_main"

    def draw(self, context):
        layout, state = self.layout, context.scene.diffraction
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(state, "implementation")
        if state.implementation == "NODES":
            layout.label(text="Up to 8 lamps, no environment", icon="INFO")
        layout.prop(state, "fresnel")
        if state.fresnel == "DIELECTRIC":
            layout.prop(state, "ior")
        layout.prop(state, "orientation")
        active = context.object.data if context.object is not None and context.object.type == "MESH" else None
        if state.orientation in {"UV", "TEXTURE"} and active is not None:
            layout.prop_search(state, "uv_map", active, "uv_layers")
        if state.orientation == "ATTRIBUTE" and active is not None:
            layout.prop_search(state, "attribute", active, "attributes")
        if state.orientation == "TEXTURE":
            layout.prop_search(state, "angle_image", bpy.data, "images")
        layout.prop(state, "rotation")
        layout.prop(state, "conserve_energy")
        if state.implementation == "OSL":
            layout.prop(state, "environment")
        layout.operator("diffraction.apply_material", icon="MATERIAL")


class DIFFRACTION_PT_active(_Sidebar, bpy.types.Panel):
    """Live controls of the active object's material"""

    bl_label = "Active Material"
    bl_parent_id = "DIFFRACTION_PT_material"

    @classmethod
    def poll(cls, context):
        ob = context.object
        active = ob.active_material if ob is not None else None
        return material.is_ours(active) and material.shader_node(active) is not None

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        active = context.object.active_material
        node = material.shader_node(active)
        layout.label(text=active.name, icon="MATERIAL")
        for name in material.LIVE_SOCKETS:
            socket = node.inputs.get(name)
            if socket is not None and not socket.is_linked:
                layout.prop(socket, "default_value", text=bpy.path.display_name(name))


CLASSES = (
    DIFFRACTION_PT_main,
    DIFFRACTION_PT_scan,
    DIFFRACTION_PT_bake,
    DIFFRACTION_PT_bake_advanced,
    DIFFRACTION_PT_material,
    DIFFRACTION_PT_active,
)
