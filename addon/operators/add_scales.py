# SPDX-License-Identifier: GPL-3.0-or-later
"""Snake scales on the material at hand: Add > Diffraction > Snake Scales, and a call of scripts."""

from __future__ import annotations

import bpy
from bpy.props import EnumProperty, FloatProperty

from ...precompute.errors import DiffractionError
from ..materials.scales import wire
from ..materials.scales.species import SPECIES
from ..versions import give_nodes


class DIFFRACTION_OT_add_snake_scales(bpy.types.Operator):
    """Give the material snake scales: relief, pigment, and a structure that leans and turns from scale to scale"""

    bl_idname = "diffraction.add_snake_scales"
    bl_label = "Snake Scales"
    bl_options = {"REGISTER", "UNDO"}

    species: EnumProperty(
        name="Snake",
        description="Whose scales",
        items=[(name, snake.label, snake.text) for name, snake in SPECIES.items()],
        default="SUNBEAM",
    )
    space: EnumProperty(
        name="Space",
        description="How scales lie on the object",
        items=(
            ("OBJECT", "Object", "By positions of the object: for any mesh"),
            ("UV", "UV Map", "Along a body whose UV map runs along it and once around it"),
        ),
        default="OBJECT",
    )
    scale_size: FloatProperty(
        name="Scale Size",
        description="Length of a scale; 0 takes the snake's own, or what can be seen on this object",
        subtype="DISTANCE",
        default=0.0,
        min=0.0,
        precision=4,
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        ob = context.object
        if _shown(context) is None and (ob is None or not hasattr(ob.data, "materials")):
            cls.poll_message_set("Select an object with a surface, or show a material in this editor")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        ob = context.object
        shown = _shown(context) or (ob.active_material if ob is not None else None)
        if shown is None:
            shown = bpy.data.materials.new(f"{SPECIES[self.species].label}")
            give_nodes(shown).nodes.clear()
            if ob is None:
                return {"CANCELLED"}
            if ob.material_slots:
                ob.active_material = shown
            else:
                ob.data.materials.append(shown)
        if not shown.is_editable:
            self.report({"ERROR"}, f"{shown.name} is linked and cannot be changed here; Make Local first")
            return {"CANCELLED"}
        context.view_layer.update()
        try:
            node, chosen = wire.add(shown, self.species, self.space, ob, self.scale_size)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for each in shown.node_tree.nodes:
            each.select = each == node
        shown.node_tree.nodes.active = node
        self.report({"INFO"}, chosen)
        if not wire.is_wired(shown.node_tree):
            self.report(
                {"INFO"}, f"Bake the preset {SPECIES[self.species].preset} and press Apply: the scales then shine by it"
            )
        return {"FINISHED"}


def _shown(context: bpy.types.Context) -> bpy.types.Material | None:
    space = context.space_data
    shown = getattr(space, "id", None) if space is not None and space.type == "NODE_EDITOR" else None
    return shown if isinstance(shown, bpy.types.Material) else None


CLASSES = (DIFFRACTION_OT_add_snake_scales,)
