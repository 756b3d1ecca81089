# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 6: what the table says, as pictures and numbers."""

from __future__ import annotations

import bpy

from .. import pictures
from ..jobs import progress
from ..operators.reflectance import IMAGE
from .sidebar import Sidebar, Stage, button, note, split


class DIFFRACTION_PT_evaluate(Stage, bpy.types.Panel):
    """What the table says of light and view"""

    bl_label = "Evaluate"
    bl_order = 6
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        column = layout.column()
        column.enabled = progress.running() is None
        column.label(text="Light from", icon="LIGHT_SUN")
        for name in ("map_theta", "map_phi", "map_size", "map_linear"):
            column.prop(state, name)
        map_button = button(layout, "diffraction.brdf_map", icon="IMAGE_DATA")
        map_button.theta, map_button.phi, map_button.size, map_button.linear = (
            state.map_theta, state.map_phi, state.map_size, state.map_linear,
        )  # fmt: skip
        icon = pictures.preview_icon(state.map_image)
        if icon:
            layout.template_icon(icon_value=icon, scale=12.0)
            layout.operator("diffraction.show_image", icon="WINDOW").name = state.map_image


class DIFFRACTION_PT_reflectance(Sidebar, bpy.types.Panel):
    """The scan against the grating equation"""

    bl_label = "Reflectance"
    bl_parent_id = "DIFFRACTION_PT_evaluate"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        column = layout.column()
        column.enabled = progress.running() is None
        column.prop(state, "plot_theta")
        column.prop(state, "plot_order")
        plot_button = button(layout, "diffraction.reflectance", icon="GRAPH")
        plot_button.theta, plot_button.order = state.plot_theta, state.plot_order
        icon = pictures.preview_icon(IMAGE)
        if icon:
            layout.template_icon(icon_value=icon, scale=12.0)
            layout.operator("diffraction.show_image", icon="WINDOW").name = IMAGE
        if state.plot_result:
            note(layout, state.plot_result)


CLASSES = (DIFFRACTION_PT_evaluate, DIFFRACTION_PT_reflectance)
