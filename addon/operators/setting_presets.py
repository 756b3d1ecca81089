# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that users keep under a name of their own: menus in the headers of the panels."""

from __future__ import annotations

import bpy
from bl_operators.presets import AddPresetBase

from ...precompute.presets import PRESETS
from ..tables import bake_settings

_STATE = "state = bpy.context.scene.diffraction"


class DIFFRACTION_MT_bake_presets(bpy.types.Menu):
    """Kept settings of levelling and bake"""

    bl_label = "Bake Settings"
    preset_subdir = "diffraction/bake"
    preset_operator = "script.execute_preset"
    draw = bpy.types.Menu.draw_preset


class DIFFRACTION_OT_bake_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep the settings of levelling and bake under a name, or forget those of a name"""

    bl_idname = "diffraction.bake_preset_add"
    bl_label = "Keep Bake Settings"
    preset_menu = "DIFFRACTION_MT_bake_presets"
    preset_subdir = "diffraction/bake"
    preset_defines = [_STATE]
    preset_values = [f"state.{name}" for name in bake_settings.FIELDS]


class DIFFRACTION_MT_structure_presets(bpy.types.Menu):
    """Kept structures: a preset with its parameters"""

    bl_label = "Structures"
    preset_subdir = "diffraction/structure"
    preset_operator = "script.execute_preset"
    draw = bpy.types.Menu.draw_preset


class DIFFRACTION_OT_structure_preset_add(AddPresetBase, bpy.types.Operator):
    """Keep a structure with its parameters under a name, or forget the one of a name"""

    bl_idname = "diffraction.structure_preset_add"
    bl_label = "Keep Structure"
    preset_menu = "DIFFRACTION_MT_structure_presets"
    preset_subdir = "diffraction/structure"
    preset_defines = [_STATE]

    @property
    def preset_values(self) -> list[str]:
        """The choice, and the parameters of the chosen structure alone."""
        chosen = bpy.context.scene.diffraction.preset
        own = [f"state.presets.{chosen}.{parameter.name}" for parameter in PRESETS[chosen].parameters]
        return ["state.preset", "state.preset_size_um", "state.preset_pixels", *own]


CLASSES = (
    DIFFRACTION_MT_bake_presets,
    DIFFRACTION_OT_bake_preset_add,
    DIFFRACTION_MT_structure_presets,
    DIFFRACTION_OT_structure_preset_add,
)
