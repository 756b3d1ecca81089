# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 2: what is taken out of the heights."""

from __future__ import annotations

import bpy

from .. import pictures
from ..jobs import progress
from ..operators.preview_levelling import IMAGE
from ..tables import estimates
from .sidebar import Stage, note, split, vector


class DIFFRACTION_PT_levelling(Stage, bpy.types.Panel):
    """What is taken out of the heights before they diffract"""

    bl_label = "Levelling"
    bl_order = 2

    def draw(self, context):
        layout, state = split(self.layout), context.scene.diffraction
        column = layout.column()
        column.enabled = progress.running() is None
        for name in ("level", "align_rows", "clip_percent", "smooth_nm", "tile", "use_crop"):
            column.prop(state, name)
        if state.use_crop:
            vector(column, state, "crop_um")
        layout.operator("diffraction.preview_levelling", icon="HIDE_OFF")
        icon = pictures.preview_icon(IMAGE)
        if icon:
            layout.template_icon(icon_value=icon, scale=11.0)
        found = estimates.estimate(context.scene)
        for warning in found.warnings if found is not None else ():
            note(layout, warning, "ERROR")


CLASSES = (DIFFRACTION_PT_levelling,)
