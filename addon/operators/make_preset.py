# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a preset structure the scene's scan."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty

from ...precompute.errors import DiffractionError
from ...precompute.presets import PRESETS, make_preset
from .. import preset_properties, properties, scan_store
from ..numbers import decimal
from .threaded import busy


class DIFFRACTION_OT_make_preset(bpy.types.Operator):
    """Take a structure that needs no microscope"""

    bl_idname = "diffraction.make_preset"
    bl_label = "Use Preset"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    preset: EnumProperty(
        name="Preset", description="A structure that needs no microscope", items=preset_properties.ITEMS
    )
    size_um: properties.preset_size()
    pixels: properties.preset_pixels()

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        for name in ("preset", *(p.name for p in PRESETS[self.preset].parameters), "size_um", "pixels"):
            layout.prop(self, name)

    def execute(self, context):
        values = {}
        for parameter in PRESETS[self.preset].parameters:
            if self.properties.is_property_set(parameter.name, ghost=False):
                value = getattr(self, parameter.name)
                values[parameter.name] = decimal(value) if isinstance(value, float) else value
            else:  # presets that share a parameter differ in its default
                values[parameter.name] = parameter.default
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        try:
            field = make_preset(self.preset, decimal(self.size_um) * 1e-6 or None, self.pixels or None, **values)
            scan_store.store_preset(context.scene, field, self.preset)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        state = context.scene.diffraction
        state.preset, state.table_name = self.preset, ""
        self.report({"INFO"}, f"{PRESETS[self.preset].label}: {state.scan_info}")
        return {"FINISHED"}


DIFFRACTION_OT_make_preset.__annotations__.update(preset_properties.all_parameters())

CLASSES = (DIFFRACTION_OT_make_preset,)
