# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of the panels, large."""

from __future__ import annotations

import bpy
from bpy.props import StringProperty

from .. import pictures


class DIFFRACTION_OT_show_image(bpy.types.Operator):
    """Open the picture in an image editor: one that is there, else in a window of its own"""

    bl_idname = "diffraction.show_image"
    bl_label = "Open Large"

    name: StringProperty(name="Image", description="Name of the image", options={"SKIP_SAVE"})

    def execute(self, context: bpy.types.Context) -> set[str]:
        image = bpy.data.images.get(self.name)
        if image is None:
            self.report({"ERROR"}, f"There is no image '{self.name}'; make it first.")
            return {"CANCELLED"}
        window, area = _editor(context) or (None, None)
        if area is None:
            if bpy.app.background:
                self.report({"ERROR"}, "There is no window to open it in.")
                return {"CANCELLED"}
            before = set(context.window_manager.windows)
            bpy.ops.screen.area_dupli("INVOKE_DEFAULT")
            (window,) = set(context.window_manager.windows) - before
            area = window.screen.areas[0]
            area.ui_type = "IMAGE_EDITOR"
        area.spaces.active.image = image
        area.tag_redraw()
        pictures.fit_soon(window, area, image)
        return {"FINISHED"}


def _editor(context: bpy.types.Context) -> tuple[bpy.types.Window, bpy.types.Area] | None:
    """An image editor that shows no other picture of importance: a render keeps its own."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                shown = area.spaces.active.image
                if shown is None or shown.type != "RENDER_RESULT":
                    return window, area
    return None


CLASSES = (DIFFRACTION_OT_show_image,)
