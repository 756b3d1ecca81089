# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 6: what the table says, as pictures and numbers."""

from __future__ import annotations

import bpy

from .. import pictures, progress
from .sidebar import Stage, split


class DIFFRACTION_PT_evaluate(Stage, bpy.types.Panel):
    """What the table says of light and view"""

    bl_label = "Evaluate"
    bl_order = 6
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, state = split(self.layout), context.scene.diffraction
        column = layout.column()
        column.enabled = progress.running() is None
        column.label(text="Light from", icon="LIGHT_SUN")
        for name in ("map_theta", "map_phi", "map_size", "map_linear"):
            column.prop(state, name)
        button = layout.operator("diffraction.brdf_map", icon="IMAGE_DATA")
        button.theta, button.phi, button.size, button.linear = (
            state.map_theta, state.map_phi, state.map_size, state.map_linear,
        )  # fmt: skip
        icon = pictures.preview_icon(state.map_image)
        if icon:
            layout.template_icon(icon_value=icon, scale=11.0)


CLASSES = (DIFFRACTION_PT_evaluate,)
