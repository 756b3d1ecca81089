# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that this scene does not render: say so, and mend it. Linked materials: make them this file's own."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ...precompute.errors import DiffractionError
from .. import renderers
from ..materials import material, setup, travel
from ..watch.misfits import misfits
from . import apply_material


class DIFFRACTION_OT_fit_renderer(bpy.types.Operator):
    """Let the scene's materials be rendered by its engine and device: OSL switched on where it runs, else Nodes"""

    bl_idname = "diffraction.fit_renderer"
    bl_label = "Make It Fit"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not misfits(context.scene):
            cls.poll_message_set("All diffraction materials fit engine and device")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        scene = context.scene
        if not renderers.why_not_osl(scene) and not scene.cycles.shading_system:
            setup.take_up(scene)
            scene.cycles.shading_system = True
            self.report({"INFO"}, "Open Shading Language is on for this scene")
            return {"FINISHED"}
        changed, kept = [], []
        for each in misfits(scene):
            if not each.is_editable:
                kept.append(each.name)
                continue
            settings = material.settings_of(each)
            try:
                apply_material.set_up(scene, each, material.table_path(each), replace(settings, implementation="NODES"))
            except DiffractionError as error:
                self.report({"ERROR"}, f"{each.name}: {error}")
                return {"CANCELLED"}
            changed.append(each.name)
        if kept:
            self.report({"WARNING"}, f"Linked, make them local first: {', '.join(kept)}")
        self.report({"INFO"}, f"Nodes in place of OSL: {', '.join(changed)}")
        return {"FINISHED"} if changed else {"CANCELLED"}


def _is_own(slot: bpy.types.MaterialSlot) -> bool:
    """Whether what holds a slot can be changed."""
    return slot.id_data is not None and slot.id_data.is_editable


class DIFFRACTION_OT_make_local(bpy.types.Operator):
    """Make the active object's linked material this file's own, so that it can be changed"""

    bl_idname = "diffraction.make_local"
    bl_label = "Make Local"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        active = context.object.active_material if context.object is not None else None
        if active is None or active.library is None:
            cls.poll_message_set("The active material is this file's own")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        ob = context.object
        linked = ob.active_material if ob is not None else None
        if ob is None or linked is None:
            return {"CANCELLED"}
        if ob.data is not None and ob.is_editable and not ob.data.is_editable:
            self.report(
                {"ERROR"}, f"{ob.name} has linked data; make the object local (Object > Relations > Make Local)."
            )
            return {"CANCELLED"}
        own = linked.make_local()
        for each in bpy.data.objects:
            for slot in each.material_slots:
                if slot.material == linked and each.is_editable and _is_own(slot):
                    slot.material = own
        travel.sync_all()
        self.report({"INFO"}, f"{own.name} is this file's own now")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_fit_renderer, DIFFRACTION_OT_make_local)
