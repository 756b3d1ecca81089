# SPDX-License-Identifier: GPL-3.0-or-later
"""What the user chooses for the viewport: in the scene, in each material, and in each 3-D view."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty

from .data.display import redraw
from .kept import renderer
from .looks import View

METHOD_ITEMS = [
    ("TABLE", "Table", "Look the colours up in the spectral table, as Cycles does: real time"),
    (
        "FLSS",
        "FLSS",
        "Sum all terms at all wavelengths for every pixel, as the thesis does: seconds to minutes a frame",
    ),
]
LIGHT_ITEMS = [
    ("SCENE", "Scene", "The lamps of the scene; the studio's where there is none"),
    ("STUDIO", "Studio", "Three lamps that stay with the viewer"),
]
NORMALISATION_ITEMS = [
    ("ABSOLUTE", "Absolute", "Radiance, as in Cycles"),
    ("RELATIVE", "Relative", "Scaled so that the mirror image of a light in a flat patch has the light's brightness"),
]
SURFACE_ITEMS = [
    ("ADD", "Add", "Add the diffraction to what the view draws"),
    ("REPLACE", "Replace", "Draw pigment and diffraction in place of the surface, as Cycles shades it"),
]
QUALITY_ITEMS = [
    ("FAST", "Fast", "One point for each lamp"),
    ("MEDIUM", "Medium", "Four points for each wide lamp"),
    ("FINE", "Fine", "Sixteen points for each wide lamp"),
]

#: Points that stand for a wide lamp.
POINTS = {"FAST": 1, "MEDIUM": 4, "FINE": 16}

#: 3-D views (addresses of their spaces) in which the user switched the drawing off; not saved.
_off: set[int] = set()


def _changed(self: Any, context: Any) -> None:
    renderer.note(set())
    redraw()


def _here(_: Any) -> bool:
    space = bpy.context.space_data
    return space is None or space.as_pointer() not in _off


def _set_here(_: Any, value: bool) -> None:
    space = bpy.context.space_data
    if space is not None:
        (_off.discard if value else _off.add)(space.as_pointer())
        _changed(None, None)


def shows(space: bpy.types.Space) -> bool:
    """Whether a 3-D view is to show diffraction."""
    return space.as_pointer() not in _off


class DIFFRACTION_PG_viewport(bpy.types.PropertyGroup):
    """The viewport's settings of a scene."""

    show: BoolProperty(
        name="Show", description="Show diffraction in the 3-D views of this scene", default=True, update=_changed
    )
    method: EnumProperty(name="Method", description="How colours are found", items=METHOD_ITEMS, update=_changed)
    lights: EnumProperty(name="Lights", description="Which lamps shine", items=LIGHT_ITEMS, update=_changed)
    surface: EnumProperty(name="Surface", description="What is drawn", items=SURFACE_ITEMS, update=_changed)
    normalisation: EnumProperty(
        name="Scale", description="What brightness means", items=NORMALISATION_ITEMS, update=_changed
    )
    brightness: FloatProperty(
        name="Brightness", description="Factor on the diffracted light in the viewport",
        default=1.0, min=0.0, soft_max=10.0, update=_changed,
    )  # fmt: skip
    quality: EnumProperty(
        name="Quality", description="How finely wide lamps are drawn", items=QUALITY_ITEMS, default="MEDIUM",
        update=_changed,
    )  # fmt: skip

    def view(self) -> View:
        """The settings as the renderer takes them."""
        return View(
            method=self.method,
            brightness=self.brightness,
            normalisation=self.normalisation,
            surface=self.surface,
            points=POINTS[self.quality],
            lights=self.lights,
        )


class DIFFRACTION_PG_viewport_material(bpy.types.PropertyGroup):
    """The viewport's settings of a material."""

    show: BoolProperty(
        name="Show in Viewport", description="Draw this material's diffraction in 3-D views", default=True,
        update=_changed,
    )  # fmt: skip


CLASSES = (DIFFRACTION_PG_viewport, DIFFRACTION_PG_viewport_material)


def register() -> None:
    """Attach the groups."""
    bpy.types.Scene.diffraction_viewport = PointerProperty(type=DIFFRACTION_PG_viewport)
    bpy.types.Material.diffraction_viewport = PointerProperty(type=DIFFRACTION_PG_viewport_material)
    bpy.types.WindowManager.diffraction_here = BoolProperty(
        name="In This View", description="Show diffraction in this 3-D view", get=_here, set=_set_here
    )


def unregister() -> None:
    """Detach them; values stay in the files."""
    del bpy.types.WindowManager.diffraction_here
    del bpy.types.Material.diffraction_viewport
    del bpy.types.Scene.diffraction_viewport
    _off.clear()
