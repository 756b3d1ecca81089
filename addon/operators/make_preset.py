# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a preset structure the scene's scan."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty

from ...precompute.errors import DiffractionError
from ...precompute.presets import PRESETS, make_preset
from .. import scan_store
from ..numbers import decimal


class DIFFRACTION_OT_make_preset(bpy.types.Operator):
    """Take a structure that needs no microscope"""

    bl_idname = "diffraction.make_preset"
    bl_label = "Use Preset"
    bl_options = {"REGISTER", "UNDO"}

    preset: EnumProperty(
        name="Preset", items=[(preset.name, preset.label, preset.description) for preset in PRESETS.values()]
    )
    size_um: FloatProperty(
        name="Size", description="Side length in micrometres; 0 takes the preset's", default=0.0, min=0.0
    )
    pixels: IntProperty(name="Pixels", description="Pixels along a side; 0 takes the preset's", default=0, min=0)

    def execute(self, context):
        try:
            field = make_preset(self.preset, decimal(self.size_um) * 1e-6 or None, self.pixels or None)
            scan_store.store_preset(context.scene, field, self.preset)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{PRESETS[self.preset].label}: {context.scene.diffraction.scan_info}")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_make_preset,)
