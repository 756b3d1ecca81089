# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyframes for lamps that instances bring: a farm then needs no extension."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty

from ...lights import keyed
from ...materials import handlers, material


class DIFFRACTION_OT_bake_lights(bpy.types.Operator):
    """Key lamps that geometry nodes, vertices or particles bring: a farm then needs no extension"""

    bl_idname = "diffraction.bake_lights"
    bl_label = "Bake Lamps to Keys"
    bl_options = {"REGISTER", "UNDO"}

    clear: BoolProperty(name="Clear", description="Take such keys away instead", default=False, options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not context.scene.is_editable:
            cls.poll_message_set("This scene is linked from another file")
            return False
        if not material.any_ours():
            cls.poll_message_set("No material diffracts here: Apply one first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        if self.clear:
            self.report({"INFO"}, "Keys of lamps are gone" if keyed.clear(scene) else "There were no keys of lamps")
            handlers.update_lights(scene)
            return {"FINISHED"}
        frames = range(scene.frame_start, scene.frame_end + 1)
        manager = context.window_manager
        manager.progress_begin(0.0, float(len(frames)))

        def write() -> None:
            manager.progress_update(float(scene.frame_current - scene.frame_start))
            handlers.update_lights(scene, context.evaluated_depsgraph_get())

        try:
            count = keyed.bake(scene, frames, write)
        finally:
            manager.progress_end()
        if not count:
            self.report({"INFO"}, "Drivers follow all lamps of this scene: nothing to key")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} lamp{'s' * (count != 1)} keyed on frames {frames[0]} to {frames[-1]}")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_bake_lights,)
