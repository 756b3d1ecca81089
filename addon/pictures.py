# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays as images of Blender, shown where the user looks."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np

from . import colour_spaces

#: Largest side of a preview in pixels.
_PREVIEW_SIDE = 320


def show(
    context: bpy.types.Context, name: str, rgb: np.ndarray, linear: bool = False, small: np.ndarray | None = None
) -> bpy.types.Image:
    """Make or replace an image data-block and show it in an image editor, if one is open.

    Parameters
    ----------
    context
        Where to look for an image editor.
    name
        Of the image; one of that name is replaced.
    rgb
        ``(height, width, 3)``, row 0 at the bottom: display values (sRGB), or linear Rec.709.
    linear
        Which of the two.
    small
        For the panel, as `rgb`; the picture itself where it is left out.
    """
    height, width, _ = rgb.shape
    image = bpy.data.images.get(name)
    if image is not None and (tuple(image.size) != (width, height) or image.is_float != linear or image.library):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(name, width, height, alpha=False, float_buffer=linear)
        image.name = name
    colour_spaces.set_picture(image, linear)
    pixels = _opaque(rgb)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()  # it has no file: without this a saved .blend would forget it
    _set_preview(image, pixels if small is None else _opaque(small))
    _into_editor(context, image)
    return image


def show_file(context: bpy.types.Context, name: str, path: Path, small: np.ndarray | None = None) -> bpy.types.Image:
    """The same for a picture in a file, which is removed."""
    old = bpy.data.images.get(name)
    image = bpy.data.images.load(str(path), check_existing=False)
    image.pack()
    if old is not None:
        old.user_remap(image)
        bpy.data.images.remove(old)
    image.name = name
    image.filepath = ""
    path.unlink(missing_ok=True)
    if small is None:
        pixels = np.empty(len(image.pixels), np.float32)
        image.pixels.foreach_get(pixels)
        _set_preview(image, pixels.reshape(image.size[1], image.size[0], -1))
    else:
        _set_preview(image, _opaque(small))
    _into_editor(context, image)
    return image


def _opaque(rgb: np.ndarray) -> np.ndarray:
    pixels = np.ones((*rgb.shape[:2], 4), np.float32)
    pixels[..., :3] = rgb
    return pixels


def _set_preview(image: bpy.types.Image, pixels: np.ndarray) -> None:
    """Preview for the panel; Blender would keep the one of the picture that was there before."""
    step = max(1, -(-max(pixels.shape[:2]) // _PREVIEW_SIDE))
    height, width = (count // step * step for count in pixels.shape[:2])
    small = pixels[:height, :width].reshape(height // step, step, width // step, step, -1).mean(axis=(1, 3))
    preview = image.preview_ensure()
    preview.image_size = (small.shape[1], small.shape[0])
    preview.image_pixels_float.foreach_set(np.ascontiguousarray(np.clip(small, 0.0, 1.0), np.float32).ravel())


def _into_editor(context: bpy.types.Context, image: bpy.types.Image) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "IMAGE_EDITOR":
                area.spaces.active.image = image
                area.tag_redraw()
                return


def preview_icon(name: str) -> int:
    """Icon of an image for `UILayout.template_icon`; 0 where there is none."""
    image = bpy.data.images.get(name)
    if image is None:
        return 0
    return image.preview_ensure().icon_id


def open_window(context: bpy.types.Context, name: str) -> None:
    """Show an image in a window of its own, unless an image editor shows it already."""
    image = bpy.data.images[name]
    areas = [area for window in context.window_manager.windows for area in window.screen.areas]
    if bpy.app.background or any(a.type == "IMAGE_EDITOR" and a.spaces.active.image == image for a in areas):
        return
    bpy.ops.wm.window_new()
    window = context.window_manager.windows[-1]
    area = window.screen.areas[0]
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = image
    fit_soon(window, area, image)


def fit_soon(window: bpy.types.Window, area: bpy.types.Area, image: bpy.types.Image) -> None:
    """Let an image editor show its picture as large as it is itself, once it has been drawn and has a size."""
    bpy.app.timers.register(lambda: _fit(window, area, image), first_interval=0.2)


def _fit(window: bpy.types.Window, area: bpy.types.Area, image: bpy.types.Image) -> None:
    try:
        if area.type == "IMAGE_EDITOR" and area.spaces.active.image == image:
            region = next(each for each in area.regions if each.type == "WINDOW")
            with bpy.context.temp_override(window=window, area=area, region=region):
                bpy.ops.image.view_all(fit_view=True)
    except ReferenceError:  # closed again
        return
