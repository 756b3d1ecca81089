# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose table was baked anew are built again: the table's layout is compiled into them."""

from __future__ import annotations

from pathlib import Path

from ...precompute.errors import DiffractionError
from ...precompute.files.stamp import Stamp, file_stamp
from ..tables.table_state import READY, table_state
from . import material as materials
from . import travel
from .node import group, keys


def broken() -> list[str]:
    """Materials that lack their table, and why, in a sentence each; cheap enough for every redraw of a panel."""
    states = ((material, table_state(materials.table_path(material))) for material in materials.of_file())
    return [f"{material.name}: {found.text}" for material, found in states if found.kind != READY]


def bring_up_to_date() -> list[str]:
    """Adapt materials to tables that were baked anew elsewhere (their layout is compiled in); what cannot be done."""
    problems = []
    for material in materials.our_materials():
        found = table_state(materials.table_path(material))
        if found.kind != READY:
            continue
        if group.owner(material).get(keys.SHA256) not in (None, found.info["atlas"].get("sha256")):
            try:
                materials.set_table(material, materials.table_path(material))
            except DiffractionError as error:
                problems.append(f"{material.name}: {error}")
    return problems


#: Time and size of the tables' files at the last look.
_seen: dict[Path, Stamp | None] = {}


def follow_files() -> list[str]:
    """Follow tables that something else (another process, a copy) wrote since the last look; what cannot be done."""
    now = {travel.home(each): file_stamp(travel.home(each)) for each in materials.of_file()}
    changed = any(_seen.get(path, stamp) != stamp for path, stamp in now.items())
    _seen.clear()
    _seen.update(now)
    if not changed:
        return []
    travel.sync_all()
    return bring_up_to_date()


def refresh(path: Path, made: str) -> None:
    """A table was baked: materials that belong to it follow, and what was packed is packed again."""
    travel.note_recipe(path, made)
    for material in materials.our_materials():
        if travel.home(material) == path:
            materials.set_table(material, path)
            travel.sync(group.owner(material))
