# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the viewport by an operator: previews and turntables for scripts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...precompute.errors import DiffractionError
from ..versions import EEVEE
from . import settings

_AS_SCENE = ("SCENE", "As Scene", "As the scene's viewport settings say")


def _items(items: list[tuple]) -> list[tuple]:
    return [_AS_SCENE, *[item for item in items if item[0] != "SCENE"]]


class DIFFRACTION_OT_viewport_render(bpy.types.Operator):
    """Write what the scene's camera sees, drawn by the viewport with diffraction, to a picture"""

    bl_idname = "diffraction.viewport_render"
    bl_label = "Viewport Picture"

    filepath: StringProperty(name="File", description="PNG, JPEG or EXR (scene-linear)", subtype="FILE_PATH")
    width: IntProperty(name="Width", description="Pixels; 0 takes the scene's resolution", default=0, min=0, max=16384)
    height: IntProperty(
        name="Height", description="Pixels; 0 takes the scene's resolution", default=0, min=0, max=16384
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

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if context.scene.camera is None:
            cls.poll_message_set("The scene has no camera")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        from . import handlers, offscreen

        if not self.filepath:
            self.report({"ERROR"}, "There is no file to write to; give filepath=.")
            return {"CANCELLED"}
        scene = context.scene
        view = scene.diffraction_viewport.view()
        chosen = {name: getattr(self, name) for name in ("method", "surface") if getattr(self, name) != "SCENE"}
        if self.quality != "SCENE":
            chosen["points"] = settings.POINTS[self.quality]
        if self.brightness >= 0.0:
            chosen["brightness"] = self.brightness
        scale = scene.render.resolution_percentage / 100.0
        size = (
            self.width or max(1, int(scene.render.resolution_x * scale)),
            self.height or max(1, int(scene.render.resolution_y * scale)),
        )
        path = Path(bpy.path.abspath(self.filepath))
        camera = scene.camera
        assert camera is not None  # see `poll`
        try:
            with _engine(scene, self.shading):
                pixels = offscreen.render(
                    handlers.renderer, scene, camera, size, self.shading, replace(view, **chosen),
                    background=not self.transparent, samples=self.samples,
                )  # fmt: skip
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
