# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether Blender hands renderers the images that were baked.

Shaders look at a guard texel and show the pigment alone where it is wrong; here stands why it is.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ...precompute.table import importance
from ..materials import material, travel
from ..materials.node import group, keys
from ..tables.table_state import table_state

_EXR = b"\x76\x2f\x31\x01"


def sentences(thorough: bool = False) -> Iterator[str]:
    """A sentence for each image of a table that is not as it was baked.

    Parameters
    ----------
    thorough
        Also look into packed files, which takes a moment: not for panels.
    """
    seen = set()
    for each in material.of_file():
        known = group.owner(each)
        if known in seen:
            continue
        seen.add(known)
        for key, _ in travel.SOCKETS:
            image = known.get(key)
            if not isinstance(image, bpy.types.Image):
                continue
            fault = _fault(image, size_of(each, key), material.needs_osl(each), thorough)
            if fault:
                what = "diffract" if key == keys.ATLAS else "show the environment"
                yield f"{image.name} {fault}: {each.name} does not {what} until that is undone or the table baked again"


def size_of(each: bpy.types.Material, key: str) -> tuple[int, int] | None:
    """Width and height of a table's image, None where that is not known."""
    if key == keys.IMPORTANCE:
        return importance.WIDTH, importance.HEIGHT
    layout = table_state(material.table_path(each)).layout
    return None if layout is None else (layout.width, layout.height)


def _fault(image: bpy.types.Image, size: tuple[int, int] | None, by_name: bool, thorough: bool) -> str:
    """What is wrong with an image, empty where nothing is; OSL reads its file by name, whatever Blender makes of it."""
    packed = image.packed_file
    if image.source != "FILE" or not image.filepath.lower().endswith(".exr"):
        return "is not the EXR that was baked"
    if thorough and packed is not None and bytes(packed.data[:4]) != _EXR:
        return "was packed as another format than EXR"
    if by_name and packed is None:
        return ""
    if not image.colorspace_settings.is_data:
        return f"has the colour space {image.colorspace_settings.name} in place of Non-Color"
    if image.has_data and size is not None and tuple(image.size) not in (size, (0, 0)):
        return f"was resized from {size[0]} x {size[1]} to {image.size[0]} x {image.size[1]} pixels"
    if image.has_data and not image.is_float and tuple(image.size) != (0, 0):
        return "was saved with 8 bits"
    return ""
