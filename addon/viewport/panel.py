# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport's part of the sidebar."""

from __future__ import annotations

import textwrap

import bpy

from ..materials import material


class DIFFRACTION_PT_viewport(bpy.types.Panel):
    """How the 3-D views show diffraction"""

    bl_label = "Viewport"
    bl_parent_id = "DIFFRACTION_PT_main"
    bl_order = 5
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "Diffraction"

    def draw_header(self, context: bpy.types.Context) -> None:
        self.layout.prop(context.scene.diffraction_viewport, "show", text="")

    def draw(self, context: bpy.types.Context) -> None:
        from . import handlers

        layout, state = self.layout, context.scene.diffraction_viewport
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.active = state.show
        layout.prop(context.window_manager, "diffraction_here")
        for name in ("surface", "lights", "brightness", "normalisation", "quality", "method"):
            layout.prop(state, name)
        active = context.object.active_material if context.object is not None else None
        if material.is_ours(active):
            layout.prop(active.diffraction_viewport, "show")
        layout.operator("diffraction.viewport_render", text="Render Picture", icon="RENDER_STILL")
        shading = getattr(context.space_data, "shading", None)
        if shading is not None and shading.type == "RENDERED" and context.scene.render.engine == "CYCLES":
            layout.label(text="Cycles shows the material itself", icon="INFO")
        if handlers.renderer.skies.message:
            layout.label(text=f"Not shown: {handlers.renderer.skies.message}", icon="INFO")
        for index, line in enumerate(textwrap.wrap(handlers.renderer.message, 44)):
            layout.label(text=line, icon="ERROR" if index == 0 else "BLANK1")


CLASSES = (DIFFRACTION_PT_viewport,)
