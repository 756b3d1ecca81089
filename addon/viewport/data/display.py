# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene's view transform as a cube of colours.

Blender calls draw handlers after the view transform, so that light drawn there must pass through it by itself. The
cube is made by Blender: a picture of known colours is saved as a render would be, and read back.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ... import colour_spaces
from ...versions import smooth_lookups
from .blocks import DISPLAY_GAIN, DISPLAY_SIDE, DISPLAY_WHITE, buffer

_VIEW = ("view_transform", "look", "exposure", "gamma", "use_curve_mapping", "use_white_balance",
         "white_balance_temperature", "white_balance_tint")  # fmt: skip


def signature(scene: bpy.types.Scene) -> tuple:
    """What decides the cube (points of a curve mapping excepted)."""
    view = scene.view_settings
    return (
        colour_spaces.file_space(),
        scene.display_settings.display_device,
        *(getattr(view, name, None) for name in _VIEW),
    )


def axis(exposure: float = 0.0) -> np.ndarray:
    """``(DISPLAY_SIDE,)`` scene-linear values along each edge of the cube, for an exposure in stops."""
    place = np.linspace(0.0, 1.0, DISPLAY_SIDE)
    return (np.exp2(place * np.log2(DISPLAY_WHITE * DISPLAY_GAIN + 1.0)) - 1.0) / (DISPLAY_GAIN * 2.0**exposure)


def plain_cube() -> np.ndarray:
    """``(side, side, side, 3)``, blue first: clipped and encoded as sRGB, for the time until the scene's is made."""
    from ....precompute.light.colour import encode_srgb

    return _cube(encode_srgb(axis()))


def _cube(values: np.ndarray) -> np.ndarray:
    """``(side, side, side, 3)`` colours that have these values along each edge."""
    blue, green, red = np.meshgrid(values, values, values, indexing="ij")
    return np.stack([red, green, blue], -1)


def make_cube(scene: bpy.types.Scene) -> np.ndarray:
    """``(side, side, side, 3)`` display values of scene-linear colours, blue first. Not to be called while drawing."""
    side = DISPLAY_SIDE
    colours = np.ones((side, side, side, 4), np.float32)
    colours[..., :3] = _cube(axis(scene.view_settings.exposure))
    saved = save_as_render(colours.reshape(side, side * side, 4), scene)
    return saved.reshape(side, side, side, 4)[..., :3]


def save_as_render(pixels: np.ndarray, scene: bpy.types.Scene) -> np.ndarray:
    """Display values ``(rows, cols, 4)`` of scene-linear pixels under a scene's colour management."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        write_as_render(pixels, scene, path, "PNG", "16", compression=0)  # it is read at once
        image = bpy.data.images.load(str(path))
        try:
            colour_spaces.set_data(image)
            out = np.empty(pixels.size, np.float32)
            image.pixels.foreach_get(out)
            return out.reshape(pixels.shape)
        finally:
            bpy.data.images.remove(image)


def write_as_render(
    pixels: np.ndarray, scene: bpy.types.Scene, path: Path, file_format: str, depth: str, transparent: bool = False,
    compression: int | None = None,
) -> None:  # fmt: skip
    """Write scene-linear pixels ``(rows, cols, 4)``, row 0 at the bottom, as a render of the scene would be written.

    `compression` is a PNG's, in percent; None: Blender's own.
    """
    rows, cols, _ = pixels.shape
    image = bpy.data.images.new("diffraction picture", cols, rows, alpha=True, float_buffer=True)
    # Another scene lends its output settings: those of the user's must not even change for a moment.
    lender = bpy.data.scenes.new("diffraction picture")
    try:
        colour_spaces.set_scene_linear(image)
        image.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).ravel())
        copy_colour_management(scene, lender)
        settings = lender.render.image_settings
        settings.file_format = file_format
        settings.color_mode = "RGBA" if transparent and file_format != "JPEG" else "RGB"
        if file_format in {"PNG", "TIFF", "OPEN_EXR"}:
            settings.color_depth = depth
        if compression is not None:
            settings.compression = compression
        lender.render.dither_intensity = 0.0
        image.save_render(str(path), scene=lender)
    finally:
        bpy.data.images.remove(image)
        bpy.data.scenes.remove(lender)


def copy_colour_management(source: bpy.types.Scene, target: bpy.types.Scene) -> None:
    """Give a scene the view transform of another."""
    target.display_settings.display_device = source.display_settings.display_device
    for name in _VIEW:
        if hasattr(source.view_settings, name):
            setattr(target.view_settings, name, getattr(source.view_settings, name))
    if source.view_settings.use_curve_mapping:
        mine, theirs = target.view_settings.curve_mapping, source.view_settings.curve_mapping
        mine.black_level, mine.white_level = theirs.black_level, theirs.white_level
        for to_curve, from_curve in zip(mine.curves, theirs.curves, strict=True):
            while len(to_curve.points) < len(from_curve.points):
                to_curve.points.new(0.5, 0.5)
            for to_point, from_point in zip(to_curve.points, from_curve.points, strict=False):
                to_point.location, to_point.handle_type = from_point.location, from_point.handle_type
        mine.update()


class Display:
    """The cube on the GPU, made anew when the scene's colour management changes."""

    def __init__(self) -> None:
        self._signature: tuple | None = None
        self._texture: Any = None
        self._waiting = False

    def texture(self, scene: bpy.types.Scene, wait: bool = False) -> Any:
        """The texture; while the scene's own is in the making, the last one or a plain one.

        Parameters
        ----------
        wait
            Make it now: allowed in operators, not while Blender draws.
        """
        wanted = signature(scene)
        if wanted != self._signature:
            if wait:
                self._set(wanted, make_cube(scene))
            else:
                self._make_soon(scene)
        return self.any()

    def any(self) -> Any:
        """The texture as it is: for drawings that need one bound and do not look at it."""
        if self._texture is None:
            self._texture = _upload(plain_cube())
        return self._texture

    def clear(self) -> None:
        """Let go of the texture; another file also lets go of what waits to make one."""
        self._signature = self._texture = None
        self._waiting = False

    def _set(self, signature_: tuple, cube: np.ndarray) -> None:
        self._texture, self._signature = _upload(cube), signature_

    def _make_soon(self, scene: bpy.types.Scene) -> None:
        if self._waiting:
            return
        self._waiting = True
        name, prepared = scene.name_full, False

        def make() -> float | None:
            nonlocal prepared
            self._waiting = False
            found = next((s for s in bpy.data.scenes if s.name_full == name), None)
            if found is not None and not prepared:
                # Blender prepares a view transform when it is first used, for a tenth of a second: not in one go with
                # the cube, which takes half as long.
                save_as_render(np.ones((1, 1, 4), np.float32), found)
                prepared = self._waiting = True
                return 0.0
            if found is not None:
                self._set(signature(found), make_cube(found))
                redraw()
            return None

        bpy.app.timers.register(make, first_interval=0.0)


def redraw(areas: set[int] | None = None) -> None:
    """Ask 3-D views to draw again: those at these addresses, all for None."""
    for manager in bpy.data.window_managers:
        for window in manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D" and (areas is None or area.as_pointer() in areas):
                    area.tag_redraw()


def _upload(cube: np.ndarray) -> Any:
    import gpu

    side = cube.shape[0]
    texels = np.ones((side, side, side, 4), np.float32)
    texels[..., :3] = cube
    texture = gpu.types.GPUTexture((side, side, side), format="RGBA16F", data=buffer(texels))
    smooth_lookups(texture)
    return texture
