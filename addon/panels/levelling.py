# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 2: what is taken out of the heights."""

from __future__ import annotations

import bpy

from .. import pictures
from ..jobs import progress
from ..operators.preview_levelling import IMAGE
from ..tables import estimates
from .sidebar import Stage, button, note, number, split


class DIFFRACTION_PT_levelling(Stage, bpy.types.Panel):
    """What is taken out of the heights before they diffract"""

    bl_label = "Levelling"
    bl_order = 2

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        column = layout.column()
        column.enabled = progress.running() is None
        column.prop(state, "level")
        column.prop(state, "align_rows")
        number(column, state, "clip_percent", "off")
        number(column, state, "smooth_nm", "off")
        column.prop(state, "tile")
        column.prop(state, "use_crop")
        if state.use_crop:
            for index, side in enumerate(("Left (um)", "Right", "Bottom", "Top")):
                column.prop(state, "crop_um", index=index, text=side)
        button(layout, "diffraction.preview_levelling", icon="HIDE_OFF")
        icon = pictures.preview_icon(IMAGE)
        if icon:
            layout.template_icon(icon_value=icon, scale=12.0)
            layout.operator("diffraction.show_image", icon="WINDOW").name = IMAGE
        found = estimates.estimate(context.scene)
        for warning in found.warnings if found is not None else ():
            note(layout, warning, "ERROR")


CLASSES = (DIFFRACTION_PT_levelling,)
