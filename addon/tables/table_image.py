# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of Blender's that hold a table, read again only when their file is another one.

An atlas has some hundred megabytes: to read and pack it holds the window, and whatever draws with it copies it to the
GPU anew. So an image remembers which file it was read from, as a custom property, which undo and files keep with it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ...precompute.files.stamp import file_stamp
from .. import colour_spaces, paths

#: Custom property: the file's stamp, and the hash of the table that it holds.
READ = "diffraction_read"


def load(path: Path, content: str) -> bpy.types.Image:
    """A new image of a file; see `bring_up_to_date`."""
    image = bpy.data.images.load(str(path), check_existing=False)
    _prepare(image, path)
    image[READ] = _mark(path, content)
    return image


def bring_up_to_date(image: bpy.types.Image, path: Path, content: str) -> None:
    """Let an image hold what its file holds now; what is packed is packed again.

    Parameters
    ----------
    image
        One of this file's own.
    path
        Its file, which is there.
    content
        Hash of the table: file systems count time in steps of up to two seconds, within which the same number and size
        may come again.
    """
    mark = _mark(path, content)
    if not _is_current(image, mark):
        packed = image.packed_file is not None
        if packed:
            image.unpack(method="REMOVE")  # a packed image would reload its old self
        image.reload()
        if packed:
            image.pack()
        image.update_tag()  # else Cycles keeps what it has read with Persistent Data
        image[READ] = mark
    _prepare(image, path)


def _mark(path: Path, content: str) -> str:
    return " ".join(map(str, (*(file_stamp(path) or ()), content)))


def _is_current(image: bpy.types.Image, mark: str) -> bool:
    """Whether nothing has to be read; an image that could not be read once has no data, and costs nothing to reload."""
    return image.get(READ) == mark and not image.is_dirty and (image.packed_file is not None or image.has_data)


def _prepare(image: bpy.types.Image, path: Path) -> None:
    """Name and settings; Blender reads an image again for each that is written, the same value or not."""
    colour_spaces.set_data(image)
    wanted: dict[str, Any] = {
        "name": path.stem, "alpha_mode": "NONE", "use_fake_user": True, "filepath": paths.relative(path),
    }  # fmt: skip
    for name, value in wanted.items():
        if getattr(image, name) != value:
            setattr(image, name, value)
