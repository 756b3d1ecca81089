# SPDX-License-Identifier: GPL-3.0-or-later
"""What runs by itself: materials learn of lamps that come, go or change their type, and of the working space.

Everything else (moves, animation, sizes) goes through drivers and needs no add-on.
"""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..colour_spaces import file_space
from . import lights, material, setup

_signatures: dict[int, tuple] = {}
_at_work = False


def update_lamps(scene: bpy.types.Scene, force: bool = False) -> bool:
    """Bind the materials of a scene to its lamps again if those changed; True if anything was done."""
    global _at_work
    if _at_work:
        return False
    materials = material.our_materials()
    if not materials:
        return False
    signature = (
        lights.signature(scene),
        file_space(),
        tuple(m.as_pointer() for m in materials),
    )
    key = scene.as_pointer()
    if not force and _signatures.get(key) == signature:
        return False
    _at_work = True
    try:
        lamps = lights.lamp_objects(scene)
        for each in materials:
            material.follow_lamps(each, scene)
            node = material.shader_node(each)
            material.set_working_space(node, each.get("diffraction_illuminant", "D65"))
        setup.prepare_scene(scene, lamps, any(map(material.needs_osl, materials)))
        _signatures[key] = signature
        limit = min(map(material.lamps_max, materials))
        text = lights.too_many(lamps, limit) if len(lamps) > limit else ""
        if hasattr(scene, "diffraction") and scene.diffraction.message != text:
            scene.diffraction.message = text
    finally:
        _at_work = False
    return True


@persistent
def _depsgraph_updated(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if _at_work or not material.any_ours():
        return
    kinds = (bpy.types.Object, bpy.types.Light, bpy.types.Collection, bpy.types.Scene, bpy.types.Material)
    if any(isinstance(update.id, kinds) for update in depsgraph.updates):
        update_lamps(scene)


@persistent
def _file_loaded(*_) -> None:
    _signatures.clear()
    for scene in bpy.data.scenes:
        update_lamps(scene)


@persistent
def _before_render(scene: bpy.types.Scene, *_) -> None:
    update_lamps(scene)


_HANDLERS = (
    (bpy.app.handlers.depsgraph_update_post, _depsgraph_updated),
    (bpy.app.handlers.load_post, _file_loaded),
    (bpy.app.handlers.render_init, _before_render),
)


def register() -> None:
    """Begin to follow."""
    for where, handler in _HANDLERS:
        if handler not in where:
            where.append(handler)


def unregister() -> None:
    """Stop."""
    for where, handler in _HANDLERS:
        if handler in where:
            where.remove(handler)
    _signatures.clear()
