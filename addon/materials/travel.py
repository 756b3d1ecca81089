# SPDX-License-Identifier: GPL-3.0-or-later
"""What keeps materials whole when their .blend travels: Save As, append, link, copy, pack, another folder.

OSL reads its images by a name in a socket, and Blender's path tools know nothing of sockets. They do know images.
So a group points to the images of its table; whatever Blender does to those, the sockets follow. Packed images
whose files are gone are written to a folder of the extension's own, because OSL cannot read a packed file.

Sockets of linked groups follow too, in memory: Blender saves nothing of linked data, so a file that links an OSL
material renders right only where the add-on is there. Groups of the kind Nodes have no such limit.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from typing import Any

import bpy

from ...precompute.errors import DiffractionError
from ...precompute.files.atomic import atomic_path
from .. import paths
from ..tables import recipe
from . import spelling
from .node import group
from .node.keys import ATLAS, IMPORTANCE, TABLE

#: Custom properties that point to images, and the sockets of the script node that name them.
SOCKETS = ((ATLAS, "Atlas"), (IMPORTANCE, "Importance"))


def note_scene_recipe(tree: bpy.types.NodeTree) -> None:
    """Let a group know how its table was made, where a scene knows."""
    path = paths.absolute(tree[ATLAS].filepath)
    for scene in bpy.data.scenes:
        state = getattr(scene, "diffraction", None)
        if state is not None and state.table_recipe and paths.absolute(state.table_path) == path:
            tree[recipe.KEY] = state.table_recipe


def note_recipe(path: Path, made: str) -> None:
    """Groups of a table remember how it was made."""
    for each in owners():
        if each.is_editable and _home(each) == path:
            each[recipe.KEY] = made


def owners() -> list[bpy.types.ID]:
    """Whatever in the file knows a table: groups, and materials that version 0.1.0 made."""
    return [*group.trees(), *(m for m in bpy.data.materials if TABLE in m and group.owner(m) is m)]


def recipe_of(material: bpy.types.Material) -> dict[str, Any]:
    """How a material's table was made; empty where that is not known."""
    return recipe.of(group.owner(material))


def images_of(material: bpy.types.Material) -> list[bpy.types.Image]:
    """The images of a material's table."""
    known = group.owner(material)
    return [known[key] for key, _ in SOCKETS if isinstance(known.get(key), bpy.types.Image)]


def home(material: bpy.types.Material) -> Path:
    """Where a material's table belongs, whether it is there or not."""
    return _home(group.owner(material))


def _home(known: bpy.types.ID) -> Path:
    atlas = known.get(ATLAS)
    if isinstance(atlas, bpy.types.Image):
        return paths.absolute(atlas.filepath, atlas.library)
    return paths.absolute(known[TABLE], known.library)


def is_packed(material: bpy.types.Material) -> bool:
    """Whether the .blend holds the material's table."""
    atlas = group.owner(material).get(ATLAS)
    return isinstance(atlas, bpy.types.Image) and atlas.packed_file is not None


def sync(known: bpy.types.ID, folder: Path | None = None) -> bool:
    """Write the images' places into the sockets; True if anything changed.

    Parameters
    ----------
    known
        One of `owners`.
    folder
        Write paths as seen from here (the .blend is about to be saved there); None takes what can be read now.
    """
    linked = known.library is not None
    tree: Any = known.node_tree if isinstance(known, bpy.types.Material) else known
    if tree is None or (linked and folder is not None):
        return False
    node = group.script_of(tree)
    changed = False
    for key, name in SOCKETS:
        image = known.get(key)
        if not isinstance(image, bpy.types.Image):
            continue
        place = _readable(image) if folder is None else seen_from(image, folder)
        if linked:  # Cycles takes a relative name in a socket for one beside the open file
            place = str(paths.absolute(place, image.library))
        socket = node.inputs.get(name) if node is not None else None
        if socket is not None and socket.type == "STRING":
            read = place if folder is not None else spelling.fresh(place, paths.absolute(place, image.library))
            if socket.default_value != read:
                socket.default_value = read
                changed = True
        if key == ATLAS and not linked and known[TABLE] != place:
            known[TABLE] = place
            changed = True
    return changed


def sync_all() -> None:
    """All of the file."""
    for each in owners():
        sync(each)


def _readable(image: bpy.types.Image) -> str:
    """A path that OSL can read now: the image's own, or that of an unpacked copy."""
    if image.packed_file is None or paths.absolute(image.filepath, image.library).is_file():
        return image.filepath
    try:
        return str(_unpack(image))
    except DiffractionError:
        return image.filepath


def _unpack(image: bpy.types.Image) -> Path:
    """A packed image as a file, with the sidecar that its header carries."""
    assert image.packed_file is not None  # of what else would it be a file
    content = image.packed_file.data
    target = unpacked_place(image)
    if not target.is_file() or hashlib.sha256(target.read_bytes()).digest() != hashlib.sha256(content).digest():
        with atomic_path(target) as temporary:
            temporary.write_bytes(content)
    _write_sidecar(target)
    return target


def _write_sidecar(target: Path) -> None:
    """The JSON beside a table's EXR, from the text that its header carries."""
    from ...precompute.files.exr import read_text

    text = read_text(target)
    if text and not target.stem.endswith(".importance"):
        with atomic_path(target.with_suffix(".json")) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")


def write_sidecar(known: bpy.types.ID) -> None:
    """The JSON beside the table of one of `owners`, where the EXR stands alone."""
    home_ = _home(known)
    if home_.is_file() and not home_.with_suffix(".json").exists():
        _write_sidecar(home_)


def beside(folder: Path) -> list[Path]:
    """Tables of OSL materials that a .blend in a folder needs beside itself, since OSL reads files alone."""
    found: dict[Path, None] = {}  # in order, once each
    for each in owners():
        atlas = each.get(ATLAS)
        tree: Any = each.node_tree if isinstance(each, bpy.types.Material) else each
        if isinstance(atlas, bpy.types.Image) and atlas.packed_file is None and tree is not None:
            script = group.script_of(tree)
            if script is not None and script.bl_idname == "ShaderNodeScript":
                found[_home(each)] = None
    return [path for path in found if path.is_relative_to(folder)]


def unpacked_place(image: bpy.types.Image) -> Path:
    """Where a packed image is written: a table and its image of directions side by side, under their own names."""
    place = Path(image.filepath.replace("//", "").replace("\\", "/"))
    folder = hashlib.sha256(f"{bpy.data.filepath}|{place.parent}".encode()).hexdigest()[:16]
    return paths.unpack_folder() / folder / place.name


def seen_from(image: bpy.types.Image, folder: Path) -> str:
    path = image.filepath
    if not path.startswith("//"):
        return path
    try:
        return bpy.path.relpath(str(paths.absolute(path)), start=str(folder)).replace("\\", "/")
    except ValueError:  # another drive
        return str(paths.absolute(path))
