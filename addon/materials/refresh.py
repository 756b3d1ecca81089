# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials whose table was baked anew are built again: the table's layout is compiled into them."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...precompute.errors import DiffractionError
from ..tables.table_state import READY, table_state
from . import lights, travel
from . import material as materials


def bring_up_to_date(scene: bpy.types.Scene) -> list[str]:
    """Adapt materials to tables that were baked anew elsewhere (their layout is compiled in); what cannot be done."""
    problems = []
    for material in materials.our_materials():
        found = table_state(materials.table_path(material))
        if found.kind != READY:
            problems.append(f"{material.name}: {found.text}")
        elif material.get(travel.SHA256) not in (None, found.info["atlas"].get("sha256")):
            try:
                lamps = lights.lamp_objects(scene)
                materials.apply(material, materials.table_path(material), materials.settings_of(material), lamps)
            except DiffractionError as error:
                problems.append(f"{material.name}: {error}")
    return problems


def refresh(path: Path, scene: bpy.types.Scene, made: str) -> None:
    """A table was baked: materials that belong to it follow, and what was packed is packed again."""
    travel.note_recipe(path, made)
    for material in materials.our_materials():
        if travel.home(material) == path:
            packed = travel.is_packed(material)
            materials.apply(material, path, materials.settings_of(material), lights.lamp_objects(scene))
            if packed:
                for key, _ in travel.SOCKETS:
                    if isinstance(material.get(key), bpy.types.Image):
                        material[key].pack()
            travel.sync(material)
