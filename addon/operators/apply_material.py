# SPDX-License-Identifier: GPL-3.0-or-later
"""Give the selected objects a material that renders the scene's table."""

from __future__ import annotations

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...precompute.errors import DiffractionError
from .. import paths, properties
from ..given import take
from ..lights import gather
from ..materials import handlers, material, setup
from ..versions import give_nodes, limits

_FROM_PANEL = (
    "implementation",
    "fresnel",
    "ior",
    "conserve_energy",
    "orientation",
    "uv_map",
    "attribute",
    "angle_image",
    "rotation",
    "environment",
)


class DIFFRACTION_OT_apply_material(bpy.types.Operator):
    """Make the selected objects diffract; a material they have stays underneath as pigment"""

    bl_idname = "diffraction.apply_material"
    bl_label = "Apply"
    bl_options = {"REGISTER", "UNDO"}

    implementation: EnumProperty(
        name="Implementation", description="What renders the material", items=properties.IMPLEMENTATION_ITEMS
    )
    fresnel: EnumProperty(
        name="Fresnel",
        description="How much the surface reflects",
        items=properties.FRESNEL_ITEMS,
        default="DIELECTRIC",
    )
    ior: properties.ior()
    conserve_energy: BoolProperty(name="Conserve Energy", default=True)
    orientation: EnumProperty(
        name="Orientation", description="How the scan lies on the surface", items=properties.ORIENTATION_ITEMS
    )
    attribute: StringProperty(name="Attribute", description="Vector attribute of ATTRIBUTE")
    angle_image: StringProperty(name="Image", description="Image of TEXTURE")
    uv_map: StringProperty(name="UV Map", description="Whose tangent is the scan's x; empty takes the active one")
    rotation: FloatProperty(name="Rotation", description="Turn of the scan on the surface", subtype="ANGLE")

    environment: IntProperty(
        name="Environment", description="Random mirrors a sample for world, emitters and bounce light; 0: lamps only",
        default=1, min=0, max=8,
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        if not context.scene.diffraction.table_path:
            cls.poll_message_set("Bake a table first")
            return False
        if not any(_takes_material(ob) for ob in context.selected_objects):
            cls.poll_message_set("Select an object with a surface")
            return False
        return True

    def execute(self, context):
        take(self, context.scene.diffraction, _FROM_PANEL)
        settings = material.Settings(
            implementation=self.implementation,
            fresnel=self.fresnel,
            ior=self.ior,
            conserve_energy=self.conserve_energy,
            orientation=self.orientation,
            uv_map=self.uv_map,
            attribute=self.attribute,
            angle_image=self.angle_image,
            rotation=self.rotation,
            environment=self.environment,
        )
        table = paths.absolute(context.scene.diffraction.table_path)
        context.view_layer.update()  # new lamps are not yet in the layer
        setup.take_up(context.scene)
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)  # a table's first material makes the image that directs rays, half a second
        try:
            made = {}
            for ob in context.selected_objects:
                if _takes_material(ob):
                    _give(ob, table, settings, made)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        handlers.update_all()
        found = handlers.search(context.scene)
        notes = setup.prepare_scene(context.scene, self.implementation == "OSL")
        self.report({"INFO"}, ". ".join([f"{len(made)} material{'s' * (len(made) != 1)} set up", *notes]))
        if not found.chosen and context.scene.world is None:
            self.report({"WARNING"}, "The scene has no lamp: add one to see the colours")
        for sentence in limits():
            self.report({"INFO"}, sentence)
        if found.left_out:
            self.report({"WARNING"}, gather.too_many(found))
        return {"FINISHED"}


def _takes_material(ob: bpy.types.Object) -> bool:
    return ob.type in {"MESH", "CURVE", "SURFACE", "META", "FONT"} and ob.is_editable and ob.data.is_editable


def _give(ob, table, settings, made) -> None:
    """Set an object's active material up; objects that shared one share the new one."""
    old = ob.active_material
    if old not in made:
        if material.is_ours(old) and old.is_editable:
            new = old
        elif old is not None:
            new = old.copy()
            new.name = f"{old.name} diffraction"
        else:
            new = bpy.data.materials.new(f"Diffraction {table.stem}")
            give_nodes(new).nodes.clear()
        made[old] = material.apply(new, table, settings)
    if ob.material_slots:
        ob.active_material = made[old]
    else:
        ob.data.materials.append(made[old])


class DIFFRACTION_OT_restore_settings(bpy.types.Operator):
    """Give back the settings of scene and materials that Apply changed; diffraction then renders wrongly"""

    bl_idname = "diffraction.restore_settings"
    bl_label = "Restore Settings"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        if not setup.changes(context.scene):
            cls.poll_message_set("Nothing was changed")
            return False
        return True

    def execute(self, context):
        count = setup.restore_scene(context.scene)
        self.report({"INFO"}, f"Restored {count} setting{'s' * (count != 1)}; Apply sets them again")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_apply_material, DIFFRACTION_OT_restore_settings)
