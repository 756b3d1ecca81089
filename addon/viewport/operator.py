# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the viewport by an operator: previews and turntables for scripts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...precompute.errors import DiffractionError
from .. import pictures
from ..versions import EEVEE
from . import settings
from .data.display import save_as_render

#: The image that the button makes.
IMAGE = "Viewport Picture"

_AS_SCENE = ("SCENE", "As Scene", "As the scene's viewport settings say")


def _items(items: list[tuple]) -> list[tuple]:
    return [_AS_SCENE, *[item for item in items if item[0] != "SCENE"]]


class DIFFRACTION_OT_viewport_render(bpy.types.Operator):
    """Draw what the scene's camera or the 3-D view sees, with diffraction, to a picture"""

    bl_idname = "diffraction.viewport_render"
    bl_label = "Viewport Picture"

    filepath: StringProperty(name="File", description="PNG, JPEG or EXR (scene-linear)", subtype="FILE_PATH")
    width: IntProperty(name="Width", description="Pixels; 0 takes the scene's resolution", default=0, min=0, max=16384)
    height: IntProperty(
        name="Height", description="Pixels; 0 takes the scene's resolution", default=0, min=0, max=16384
    )
    eye: EnumProperty(
        name="Seen From",
        description="Whose view is drawn",
        items=[
            ("CAMERA", "Camera", "The scene's camera"),
            ("VIEW", "View", "The 3-D view; width and height of 0 take the view's"),
        ],
    )
    shading: EnumProperty(
        name="Shading",
        description="What the view draws under the diffraction",
        items=[
            ("SOLID", "Solid", "Workbench"),
            ("MATERIAL", "Material Preview", "EEVEE under a studio light"),
            ("RENDERED", "Rendered", "The scene's renderer; EEVEE where that is Cycles"),
        ],
    )
    method: EnumProperty(name="Method", items=_items(settings.METHOD_ITEMS))
    surface: EnumProperty(name="Surface", items=_items(settings.SURFACE_ITEMS))
    quality: EnumProperty(name="Quality", items=_items(settings.QUALITY_ITEMS), default="FINE")
    brightness: FloatProperty(name="Brightness", description="Below 0: as the scene says", default=-1.0)
    samples: IntProperty(
        name="Samples",
        description="Points of each pixel at which diffraction is evaluated",
        default=16,
        min=1,
        max=1024,
    )
    transparent: BoolProperty(name="Transparent", description="No background", default=False)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """A button: what this view shows, as an image that a window shows."""
        self.eye = "VIEW"
        self.filepath = ""
        space = context.space_data
        shading = space.shading.type if isinstance(space, bpy.types.SpaceView3D) else "SOLID"
        self.shading = shading if shading in {"MATERIAL", "RENDERED"} else "SOLID"
        self.width = self.height = 0
        return self._draw(context, to_window=True)

    def execute(self, context: bpy.types.Context) -> set[str]:
        if not self.filepath:
            self.report({"ERROR"}, "There is no file to write to; give filepath=.")
            return {"CANCELLED"}
        return self._draw(context, to_window=False)

    def _draw(self, context: bpy.types.Context, to_window: bool) -> set[str]:
        from . import handlers, offscreen

        scene = context.scene
        if scene.camera is None and self.eye == "CAMERA":
            self.report({"ERROR"}, "The scene has no camera; add one, or draw what the view shows (eye='VIEW').")
            return {"CANCELLED"}
        view = scene.diffraction_viewport.view()
        chosen = {name: getattr(self, name) for name in ("method", "surface") if getattr(self, name) != "SCENE"}
        if self.quality != "SCENE":
            chosen["points"] = settings.POINTS[self.quality]
        if self.brightness >= 0.0:
            chosen["brightness"] = self.brightness
        scale = scene.render.resolution_percentage / 100.0
        whole = max(1, int(scene.render.resolution_x * scale)), max(1, int(scene.render.resolution_y * scale))
        if self.eye == "VIEW":
            whole = offscreen.view_size(whole)
        size = self.width or whole[0], self.height or whole[1]
        path = Path(bpy.path.abspath(self.filepath))
        try:
            with _engine(scene, self.shading):
                pixels = offscreen.render(
                    handlers.renderer, scene, scene.camera if self.eye == "CAMERA" else None, size, self.shading,
                    replace(view, **chosen),
                    background=not self.transparent, samples=self.samples,
                )  # fmt: skip
            if to_window:
                picture = save_as_render(pixels, scene)[..., :3]
                pictures.show(context, IMAGE, picture)
                pictures.open_window(context, IMAGE)
                self.report({"INFO"}, f"Drawn to the image '{IMAGE}'; Image > Save As keeps it")
                return {"FINISHED"}
            offscreen.save(pixels, scene, path, self.transparent)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Wrote {path.name}")
        return {"FINISHED"}


class _engine:
    """EEVEE in place of Cycles for a moment: a drawing of the viewport cannot wait for Cycles, which would show the
    diffraction a second time."""

    def __init__(self, scene: bpy.types.Scene, shading: str) -> None:
        self._scene = scene
        self._lend = shading == "RENDERED" and scene.render.engine == "CYCLES"

    def __enter__(self) -> None:
        if self._lend:
            self._scene.render.engine = EEVEE

    def __exit__(self, *_: object) -> None:
        if self._lend:
            self._scene.render.engine = "CYCLES"


CLASSES = (DIFFRACTION_OT_viewport_render,)
