# SPDX-License-Identifier: GPL-3.0-or-later
"""The shader editor's way to the material: Add > Diffraction."""

from __future__ import annotations

import bpy

from ...precompute.errors import DiffractionError
from .. import paths, renderers
from ..materials import material
from . import apply_material


class DIFFRACTION_OT_add_node(bpy.types.Operator):
    """Let the material shown here diffract with the scene's table; its shader stays underneath as pigment"""

    bl_idname = "diffraction.add_node"
    bl_label = "Add Diffraction"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not context.scene.diffraction.table_path:
            cls.poll_message_set("Bake a table first, in the 3-D view's sidebar")
            return False
        shown = _shown(context)
        if shown is None or not shown.is_editable:
            cls.poll_message_set("This editor shows no material that can be changed")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        state, shown = context.scene.diffraction, _shown(context)
        if shown is None:
            return {"CANCELLED"}
        implementation = state.implementation
        if implementation == "AUTO":
            implementation = renderers.choose(context.scene)[0]
        elif implementation == "OSL" and not renderers.has_osl():
            self.report({"ERROR"}, apply_material.NO_OSL)
            return {"CANCELLED"}
        settings = apply_material.settings_from(state, implementation)
        try:
            apply_material.set_up(context.scene, shown, paths.absolute(state.table_path), settings)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        node, tree = material.shader_node(shown), shown.node_tree
        if tree is not None:
            for each in tree.nodes:
                each.select = each == node
            tree.nodes.active = node
        self.report({"INFO"}, f"{shown.name} diffracts; its shader stays underneath as pigment")
        return {"FINISHED"}


def _shown(context: bpy.types.Context) -> bpy.types.Material | None:
    space = context.space_data
    shown = getattr(space, "id", None) if space is not None and space.type == "NODE_EDITOR" else None
    return shown if isinstance(shown, bpy.types.Material) else None


CLASSES = (DIFFRACTION_OT_add_node,)
