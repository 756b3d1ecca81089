# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose table was baked anew are built again: the table's layout is compiled into them."""

from __future__ import annotations

from pathlib import Path

from ...precompute.errors import DiffractionError
from ..tables.table_state import READY, table_state
from . import material as materials
from . import travel
from .node import group, keys


def broken() -> list[str]:
    """Materials that lack their table, and why, in a sentence each; cheap enough for every redraw of a panel."""
    states = ((material, table_state(materials.table_path(material))) for material in materials.our_materials())
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


def refresh(path: Path, made: str) -> None:
    """A table was baked: materials that belong to it follow, and what was packed is packed again."""
    travel.note_recipe(path, made)
    for material in materials.our_materials():
        if travel.home(material) == path:
            packed = travel.is_packed(material)
            materials.set_table(material, path)
            if packed:
                for image in travel.images_of(material):
                    image.pack()
            travel.sync(group.owner(material))
