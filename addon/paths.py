# SPDX-License-Identifier: GPL-3.0-or-later
"""Where scans and tables are kept: beside the .blend, or in the user's folder while it has none."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

from ..precompute.errors import OutputError


def data_folder() -> Path:
    """``diffraction/`` beside the .blend; for an unsaved file a folder of the extension's own. Not made here."""
    if bpy.data.filepath:
        return Path(bpy.path.abspath("//diffraction"))
    return _user_folder("tables")


def readable(path: Path) -> Path:
    """The path, where Blender can read an image from it.

    Raises
    ------
    OutputError
        If a name in it holds a backslash, which is a letter on Linux and macOS: Blender takes it for a slash.
    """
    if os.sep != "\\" and "\\" in str(path):
        folder = next(part for part in path.parts if "\\" in part)
        raise OutputError(f"Blender reads no image below '{folder}', whose name holds a backslash; rename it.")
    return path


def unpack_folder() -> Path:
    """Where packed tables are written so that OSL can read them. Not made here."""
    return _user_folder("unpacked")


def asset_folder() -> Path:
    """Where the asset library goes. Not made here."""
    return _user_folder("assets")


def _user_folder(name: str) -> Path:
    package = __package__.rpartition(".")[0]
    if package.startswith("bl_ext."):
        return Path(bpy.utils.extension_path_user(package, path=name))
    return Path(bpy.utils.user_resource("DATAFILES", path=os.path.join("diffraction_shader", name)))


def absolute(path: str, library: bpy.types.Library | None = None) -> Path:
    """Absolute path, without ``..``, of one that may begin with ``//`` (of a linked data-block: of its library)."""
    return Path(os.path.normpath(bpy.path.abspath(path, library=library)))


def relative(path: Path) -> str:
    """``//`` path where the .blend has a folder and the file lies on the same drive, else the absolute path."""
    if not bpy.data.filepath:
        return str(path)
    try:
        return bpy.path.relpath(str(path)).replace(os.sep, "/")
    except ValueError:  # another drive
        return str(path)


def manual_page(name: str) -> str:
    """A page of the guide that ships with the extension; with an empty name its folder."""
    folder = Path(__file__).resolve().parent.parent / "manual"
    return str(folder / f"{name}.html") if name else str(folder)
