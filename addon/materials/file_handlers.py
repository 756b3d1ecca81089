# SPDX-License-Identifier: GPL-3.0-or-later
"""Follows a .blend as it is saved, opened, appended, linked, undone: see `travel` and `refresh`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.app.handlers import persistent

from .. import app_handlers, notices, paths
from . import material as materials
from . import refresh, travel


@persistent
def _before_save(*arguments: Any) -> None:
    """The file gets the names that will be right in its new folder."""
    target = next((a for a in arguments if isinstance(a, str) and a), bpy.data.filepath)
    if not target:
        return
    folder = Path(bpy.path.abspath(target)).parent
    for each in travel.owners():
        travel.sync(each, folder)
    for scene in bpy.data.scenes:
        state = scene.diffraction
        for name in ("scan_path", "table_path", "illuminant_file"):
            place = getattr(state, name)
            if place and scene.is_editable:
                _places[scene.name, name] = paths.absolute(place)
                seen = _from(paths.absolute(place), folder, place)
                if seen != place:
                    setattr(state, name, seen)


#: Files of which it was said what they need beside them.
_said: set[str] = set()


def _say_what_it_needs() -> None:
    """Once a file: what is not inside it."""
    if not bpy.data.filepath or bpy.data.filepath in _said:
        return
    folder = Path(bpy.data.filepath).parent
    names = sorted({f"{path.parent.relative_to(folder).as_posix()}/" for path in travel.beside(folder)})
    if names:
        _said.add(bpy.data.filepath)
        needs = f"its folder {names[0]}" if len(names) == 1 else f"its folders {', '.join(names)}"
        print(f"Diffraction: this file needs {needs}; Material > Files > Pack into .blend carries it inside.")


#: Absolute paths of the scenes' scans and tables while a file is being saved.
_places: dict[tuple[str, str], Path] = {}


def _from(path: Path, folder: Path, before: str) -> str:
    """Relative where it was before, or where the file lies in or beside the folder."""
    if not before.startswith("//") and not path.is_relative_to(folder):
        return before
    try:
        return bpy.path.relpath(str(path), start=str(folder)).replace("\\", "/")
    except ValueError:
        return str(path)


@persistent
def _after_save(*_: object) -> None:
    """Back to what is right here and now (a copy may have been saved elsewhere)."""
    travel.sync_all()
    _say_what_it_needs()
    folder = Path(bpy.data.filepath).parent if bpy.data.filepath else None
    for (scene_name, name), path in _places.items():
        scene = bpy.data.scenes.get(scene_name)
        if scene is not None:
            state = scene.diffraction
            place = _from(path, folder, getattr(state, name)) if folder is not None else str(path)
            if getattr(state, name) != place:
                setattr(state, name, place)
    _places.clear()


@persistent
def _before_load(*_: object) -> None:
    notices.clear()


@persistent
def _loaded(*_: object) -> None:
    travel.sync_all()
    for problem in refresh.bring_up_to_date():
        notices.say(problem)
    if bpy.app.background:  # a window shows it in the panel, for as long as it is true
        for problem in refresh.broken():
            print(f"Diffraction: {problem}; the panel Diffraction > Material > Files bakes it again.")


@persistent
def _imported(*_: object) -> None:
    """After append, link and paste."""
    travel.sync_all()


@persistent
def _rendering(*_: object) -> None:
    """Tables may have been baked by another process since."""
    if bpy.app.background:
        _follow()
    elif materials.any_ours():  # a render with a window has a thread of its own, where nodes must not be made
        travel.sync_all()
        if not bpy.app.timers.is_registered(_follow):
            bpy.app.timers.register(_follow)


def _follow() -> None:
    for problem in refresh.follow_files():
        notices.say(problem)


_HANDLERS = (
    ("render_init", _rendering),
    ("save_pre", _before_save),
    ("save_post", _after_save),
    ("save_post_fail", _after_save),
    ("load_pre", _before_load),
    ("load_post", _loaded),
    ("blend_import_post", _imported),
    ("undo_post", _imported),
    ("redo_post", _imported),
)


def register() -> None:
    """Begin to follow."""
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    """Stop."""
    app_handlers.remove(_HANDLERS)
