# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of the recipes of grating paint, made from the recipes' own lists of settings."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty

from ..precompute.paint.recipe import Recipe, Setting
from ..precompute.paint.recipes import LIMIT_PIXELS, RECIPES
from .preset_properties import ItemPictures

ITEMS: list[tuple[str, str, str]] = [(recipe.name, recipe.label, recipe.description) for recipe in RECIPES.values()]

#: What the table knows itself.
OF_TABLE = ("sigma_s_um", "headroom")

#: Small pictures of the recipes, made by tools/docs/paint_pictures.py.
pictures = ItemPictures(Path(__file__).resolve().parent / "paint_pictures", ITEMS)

_UNITS = {"um": "um", "nm": "nm", "mm": "mm", "deg": "degrees"}


def settings(name: str) -> list[Setting]:
    """What a recipe lets people choose."""
    return [setting for setting in RECIPES[name].settings if setting.name not in OF_TABLE]


def _label(name: str) -> str:
    words, _, unit = name.rpartition("_")
    return (
        f"{bpy.path.display_name(words).title()} ({_UNITS[unit]})" if unit in _UNITS else name.replace("_", " ").title()
    )


def _property(setting: Setting) -> Any:
    given: dict[str, Any] = {"name": _label(setting.name), "description": setting.help, "default": setting.default}
    if isinstance(setting.default, int):
        return IntProperty(**given, min=int(setting.minimum), max=int(setting.maximum))
    return FloatProperty(**given, min=setting.minimum, max=setting.maximum, precision=3)


def _group(recipe: Recipe) -> type[bpy.types.PropertyGroup]:
    return type(
        f"DIFFRACTION_PG_paint_{recipe.name}",
        (bpy.types.PropertyGroup,),
        {
            "__annotations__": {setting.name: _property(setting) for setting in settings(recipe.name)},
            "__doc__": recipe.description,
        },
    )


GROUPS: dict[str, type[bpy.types.PropertyGroup]] = {recipe.name: _group(recipe) for recipe in RECIPES.values()}

#: What all recipes share, as the operator and the panel's group have them.
COMMON = ("recipe", "picture", "second_picture", "period_um", "pixels", "size_mm")


def recipe() -> Any:
    """What is painted."""
    return EnumProperty(name="Recipe", description="What is painted", items=ITEMS, default="rings")


def picture() -> Any:
    """Logo or photo."""
    return StringProperty(name="Picture", description="Logo or photo", subtype="FILE_PATH")


def second_picture() -> Any:
    """Of the right eye."""
    return StringProperty(name="Right Picture", description="What the right eye sees", subtype="FILE_PATH")


def period_um() -> Any:
    """Of the table's grating."""
    return FloatProperty(
        name="Period (um)", description="Period of the table's grating; 0 takes what the table says", default=0.0,
        min=0.0, precision=3,
    )  # fmt: skip


def pixels() -> Any:
    """Of the image."""
    return IntProperty(name="Pixels", description="Along the longer side", default=1024, min=1, max=LIMIT_PIXELS)


def size_mm() -> Any:
    """Of the painted surface."""
    return FloatProperty(
        name="Size (mm)", description="What the longer side measures on the object; only Lens minds", default=50.0,
        min=0.001,
    )  # fmt: skip


def all_settings() -> dict[str, Any]:
    """Every recipe's settings as properties of one operator; a name means the same in all recipes."""
    return {setting.name: _property(setting) for name in RECIPES for setting in settings(name)}


DIFFRACTION_PG_paint_recipes: Any = type(
    "DIFFRACTION_PG_paint_recipes",
    (bpy.types.PropertyGroup,),
    {
        "__annotations__": {name: PointerProperty(type=group) for name, group in GROUPS.items()},
        "__doc__": "Settings of every recipe.",
    },
)


class DIFFRACTION_PG_paint(bpy.types.PropertyGroup):
    """What Paint paints."""

    recipe: recipe()
    picture: picture()
    second_picture: second_picture()
    period_um: period_um()
    pixels: pixels()
    size_mm: size_mm()
    recipes: PointerProperty(type=DIFFRACTION_PG_paint_recipes)


CLASSES: tuple[Any, ...] = (*GROUPS.values(), DIFFRACTION_PG_paint_recipes, DIFFRACTION_PG_paint)


def prepare() -> None:
    """Before the classes are registered: the recipes get their pictures."""
    DIFFRACTION_PG_paint.__annotations__["recipe"] = EnumProperty(
        name="Recipe", description="What is painted", items=pictures.items(), default="rings"
    )
