# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that make renderers shrink images: Simplify's in Cycles, the preferences' in EEVEE's viewport.

A table's tiles run into each other then. Tables of format 2 show it by their guard and are not drawn; those of
format 1 render wrong.
"""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ..materials import material, travel
from ..materials.node import group
from ..tables.table_state import table_state
from ..versions import EEVEE, texture_t_is_down
from . import images


def sentences(scene: bpy.types.Scene, viewport: bool = True) -> Iterator[str]:
    """A sentence for each setting of a scene that shrinks tables.

    Parameters
    ----------
    scene
        Whose Simplify counts.
    viewport
        Also say what the viewport's settings do.
    """
    for suffix in ("_render", "") if viewport else ("_render",):
        yield from _of_cycles(scene, suffix)
    limit = bpy.context.preferences.system.gl_texture_limit
    if viewport and scene.render.engine == EEVEE and limit != "CLAMP_OFF":
        side = int(limit.removeprefix("CLAMP_"))
        larger = [each for each in _materials() if _side(each) > side and not material.needs_osl(each)]
        if larger:
            yield _sentence("Preferences > Viewport > Textures > Limit Size", larger)


def _of_cycles(scene: bpy.types.Scene, suffix: str) -> Iterator[str]:
    cycles = getattr(scene, "cycles", None)
    if not scene.render.use_simplify or cycles is None or scene.render.engine != "CYCLES":
        return
    known = cycles.bl_rna.properties
    name = f"texture_resolution{suffix}"  # since Blender 5.0
    # OSL of Blender 4.5 reads files by itself, whatever Simplify says.
    asked = [each for each in _materials() if not (texture_t_is_down() and material.needs_osl(each))]
    if getattr(cycles, name, 1.0) < 1.0 and asked:
        yield _sentence(f"Simplify > {known[name].name}", asked)
    name = f"texture_limit{suffix}"
    limit = getattr(cycles, name, "OFF")
    larger = [each for each in asked if limit != "OFF" and _side(each) > int(limit)]
    if larger:
        yield _sentence(f"Simplify > {known[name].name}", larger)


def _materials() -> list[bpy.types.Material]:
    """One material for each table."""
    return list({group.owner(each): each for each in material.of_file()}.values())


def _side(each: bpy.types.Material) -> int:
    """Longest side of the images of a material's table, in pixels."""
    known = group.owner(each)
    sizes = [images.size_of(each, key) for key, _ in travel.SOCKETS if isinstance(known.get(key), bpy.types.Image)]
    return max((max(size) for size in sizes if size is not None), default=0)


def _sentence(setting: str, found: list[bpy.types.Material]) -> str:
    names = ", ".join(each.name for each in found[:3]) + (" ..." if len(found) > 3 else "")
    layouts = [table_state(material.table_path(each)).layout for each in found]
    old = any(layout is not None and not layout.guarded for layout in layouts)
    effect = "colours are wrong (bake again: newer tables notice it)" if old else "there is no diffraction"
    return f"{setting} shrinks the tables of {names}: {effect} until it is off"
