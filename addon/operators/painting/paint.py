# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint the active material: recipe and pictures become an image beside the table that drives its sockets."""

from __future__ import annotations

from typing import Any

import bpy

from ....precompute.errors import DiffractionError
from ....precompute.files.pictures import read_picture
from ....precompute.paint.of_table import paint_of_table
from ....precompute.paint.recipes import RECIPES
from ....precompute.table.table import read_sidecar
from ... import paint_properties, paths
from ...given import take
from ...materials import handlers, material
from ...materials.node import paint_nodes
from ...numbers import decimal
from . import files


class DIFFRACTION_OT_paint(bpy.types.Operator):
    """Paint the active material with periods, depths and directions of its structure, by a recipe or a picture"""

    bl_idname = "diffraction.paint"
    bl_label = "Paint"
    bl_options = {"REGISTER", "UNDO"}

    recipe: paint_properties.recipe()
    picture: paint_properties.picture()
    second_picture: paint_properties.second_picture()
    period_um: paint_properties.period_um()
    pixels: paint_properties.pixels()
    size_mm: paint_properties.size_mm()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return _editable(cls, context)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        names = [name for name in paint_properties.COMMON if name not in without(self.recipe)]
        for name in (*names, *(setting.name for setting in paint_properties.settings(self.recipe))):
            layout.prop(self, name)

    def execute(self, context: bpy.types.Context) -> set[str]:
        state, shown = context.scene.diffraction.paint, active(context)
        take(self, state, paint_properties.COMMON)
        names = [setting.name for setting in paint_properties.settings(self.recipe)]
        take(self, getattr(state.recipes, self.recipe), names)
        values = {name: getattr(self, name) for name in names}
        values = {name: decimal(value) if isinstance(value, float) else value for name, value in values.items()}
        table = material.table_path(shown).with_suffix(".exr")
        try:
            chosen = [self.picture, self.second_picture][: most_pictures(self.recipe)]
            made = paint_of_table(
                self.recipe,
                read_sidecar(table),
                self.pixels,
                decimal(self.size_mm) * 1e-3,
                [read_picture(paths.absolute(each)) for each in chosen if each],
                decimal(self.period_um) * 1e-6 or None,
                **values,
            )
            image = paint_nodes.load(files.store(made, table))
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        paint_nodes.wire(shown, image)
        handlers.update_all()
        self.report({"INFO"}, files.told(made, shown.name))
        return {"FINISHED"}


DIFFRACTION_OT_paint.__annotations__.update(paint_properties.all_settings())


class DIFFRACTION_OT_remove_paint(bpy.types.Operator):
    """Take the paint off the active material; its image stays on disk"""

    bl_idname = "diffraction.remove_paint"
    bl_label = "Remove Paint"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not _editable(cls, context):
            return False
        if paint_nodes.image(active(context)) is None:
            cls.poll_message_set("The material is not painted")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        paint_nodes.remove(active(context))
        handlers.update_all()
        return {"FINISHED"}


def active(context: bpy.types.Context) -> Any:
    """The material that is painted; None where there is none."""
    return context.object.active_material if context.object is not None else None


def _editable(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    shown = active(context)
    if not material.is_ours(shown) or material.shader_node(shown) is None:
        cls.poll_message_set("Apply a table to the active object first")
        return False
    if not shown.is_editable:
        cls.poll_message_set("The material is linked from another file; make it local first")
        return False
    if "Scale" not in material.shader_node(shown).inputs:
        cls.poll_message_set("The material was made by an earlier version: apply it again")
        return False
    return True


def most_pictures(recipe: str) -> int:
    """How many pictures a recipe takes."""
    return max(RECIPES[recipe].pictures, 1 if recipe == "dots" else 0)


def without(recipe: str) -> set[str]:
    """Common properties that a recipe does not mind."""
    unused = {"picture", "second_picture"} if most_pictures(recipe) == 0 else set()
    unused |= {"second_picture"} if most_pictures(recipe) < 2 else set()
    return unused if recipe == "lens" else unused | {"size_mm"}


CLASSES = (DIFFRACTION_OT_paint, DIFFRACTION_OT_remove_paint)
