# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint the active material: recipe and pictures become an image beside the table that drives its sockets."""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...precompute.errors import DiffractionError
from ...precompute.files.output_folder import ensure_folder
from ...precompute.files.pictures import read_picture
from ...precompute.paint.maps import Paint, save_paint
from ...precompute.paint.of_table import paint_of_table
from ...precompute.paint.recipes import RECIPES
from ...precompute.table.table import read_sidecar
from .. import paint_properties, paths
from ..given import take
from ..materials import handlers, material, paint_nodes
from ..numbers import decimal


class DIFFRACTION_OT_paint(bpy.types.Operator):
    """Paint the active material with periods, depths and directions of its structure, by a recipe or a picture"""

    bl_idname = "diffraction.paint"
    bl_label = "Paint"
    bl_options = {"REGISTER", "UNDO"}

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
        state, shown = context.scene.diffraction.paint, context.object.active_material
        take(self, state, paint_properties.COMMON)
        names = [setting.name for setting in paint_properties.settings(self.recipe)]
        take(self, getattr(state.recipes, self.recipe), names)
        values = {name: getattr(self, name) for name in names}
        values = {name: decimal(value) if isinstance(value, float) else value for name, value in values.items()}
        table = material.table_path(shown).with_suffix(".exr")
        try:
            files = [self.picture, self.second_picture][: most_pictures(self.recipe)]
            made = paint_of_table(
                self.recipe,
                read_sidecar(table),
                self.pixels,
                decimal(self.size_mm) * 1e-3,
                [read_picture(paths.absolute(each)) for each in files if each],
                decimal(self.period_um) * 1e-6 or None,
                **values,
            )
            image = paint_nodes.load(_store(made, table))
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        paint_nodes.wire(shown, image)
        handlers.update_all()
        self.report({"INFO"}, _told(made, shown))
        return {"FINISHED"}


DIFFRACTION_OT_paint.__annotations__.update(paint_properties.common() | paint_properties.all_settings())


class DIFFRACTION_OT_remove_paint(bpy.types.Operator):
    """Take the paint off the active material; its image stays on disk"""

    bl_idname = "diffraction.remove_paint"
    bl_label = "Remove Paint"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not _editable(cls, context):
            return False
        if paint_nodes.image(context.object.active_material) is None:
            cls.poll_message_set("The material is not painted")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        paint_nodes.remove(context.object.active_material)
        handlers.update_all()
        return {"FINISHED"}


def _editable(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    shown = context.object.active_material if context.object is not None else None
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


def _store(made: Paint, table: Path) -> Path:
    """The paint's file beside the table. Its name follows its content: what undo goes back to is still there."""
    content = hashlib.sha256(np.ascontiguousarray(np.stack(made.maps)).tobytes()).hexdigest()[:10]
    path = ensure_folder(table.parent) / f"{table.stem}.{made.info['recipe']}.{content}.paint.exr"
    return path if path.is_file() else save_paint(made, path)


def _told(made: Paint, shown: bpy.types.Material) -> str:
    """What was painted, and what could not be shown."""
    text = f"{shown.name} is painted with {RECIPES[made.info['recipe']].label}, {made.shape[1]} x {made.shape[0]}"
    left = {name: part for name, part in made.info.get("marked", {}).items() if part >= 0.005}
    if left:
        text += "; without structure: " + ", ".join(f"{100 * part:.0f} % {_WHY[name]}" for name, part in left.items())
    return text


#: Of `precompute.paint.picture`.
_WHY: dict[str, Any] = {
    "grey": "too grey", "purple": "purple, which no wavelength is", "period_too_large": "of a period above the table's",
    "band_too_wide": "at the ends of the spectrum",
}  # fmt: skip

CLASSES = (DIFFRACTION_OT_paint, DIFFRACTION_OT_remove_paint)
