# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays as images of Blender, shown where the user looks."""

from __future__ import annotations

import tempfile
import uuid
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from . import colour_spaces

#: Largest side of a preview in pixels.
_PREVIEW_SIDE = 320


@dataclass(frozen=True)
class Picture:
    """A picture in a file.

    Parameters
    ----------
    path
        The file, a PNG or an EXR; it is removed when an image was made of it.
    small
        ``(height, width, 3)`` display values for the panel, row 0 at the bottom, no side longer than a preview's.
    linear
        Whether the file holds linear Rec.709, not display values (sRGB).
    """

    path: Path
    small: np.ndarray
    linear: bool = False


def scratch_folder() -> Path:
    """Where `written` puts files; to be asked for in the main thread."""
    return Path(bpy.app.tempdir or tempfile.gettempdir())


def written(folder: Path, rgb: np.ndarray, linear: bool = False, small: np.ndarray | None = None) -> Picture:
    """A picture for `show_file`; touches nothing of Blender, so that a thread may do it.

    To compress a million pixels takes a tenth of a second, for which a window would wait.

    Parameters
    ----------
    folder
        Of the file, see `scratch_folder`.
    rgb
        ``(height, width, 3)``, row 0 at the bottom: display values (sRGB), or linear Rec.709.
    linear
        Which of the two.
    small
        For the panel, display values; the picture itself where it is left out.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    from ..precompute.files.images import write_exr, write_png

    path = folder / f"diffraction_{uuid.uuid4().hex}{'.exr' if linear else '.png'}"
    write = write_exr if linear else write_png
    write(path, rgb)
    return Picture(path, _reduced(rgb if small is None else small), linear)


def show(context: bpy.types.Context, name: str, rgb: np.ndarray, linear: bool = False) -> bpy.types.Image:
    """`show_file` of what is `written` now.

    Raises
    ------
    OutputError
        If the folder of temporary files cannot be written.
    """
    return show_file(context, name, written(scratch_folder(), rgb, linear))


def show_file(context: bpy.types.Context, name: str, picture: Picture) -> bpy.types.Image:
    """Make or replace an image data-block and show it in an image editor, if one is open.

    Parameters
    ----------
    context
        Where to look for an image editor.
    name
        Of the image; one of that name is replaced.
    picture
        Its file is removed.
    """
    old = bpy.data.images.get(name)
    image = bpy.data.images.load(str(picture.path), check_existing=False)
    image.pack()
    if old is not None:
        old.user_remap(image)
        bpy.data.images.remove(old)
    image.name = name
    image.filepath = ""
    picture.path.unlink(missing_ok=True)
    colour_spaces.set_picture(image, picture.linear)
    _set_preview(image, picture.small)
    _into_editor(context, image)
    return image


def _reduced(rgb: np.ndarray) -> np.ndarray:
    """The mean of squares of pixels, so that no side is longer than a preview's."""
    step = max(1, -(-max(rgb.shape[:2]) // _PREVIEW_SIDE))
    if step == 1:
        return rgb
    height, width = (count // step * step for count in rgb.shape[:2])
    return rgb[:height, :width].reshape(height // step, step, width // step, step, -1).mean(axis=(1, 3))


def _set_preview(image: bpy.types.Image, rgb: np.ndarray) -> None:
    """Preview for the panel; Blender would keep the one of the picture that was there before."""
    small = np.ones((*rgb.shape[:2], 4), np.float32)
    small[..., :3] = np.clip(rgb, 0.0, 1.0)
    preview = image.preview_ensure()
    preview.image_size = (small.shape[1], small.shape[0])
    preview.image_pixels_float.foreach_set(small.ravel())


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
