# SPDX-License-Identifier: GPL-3.0-or-later
"""What runs by itself: each scene's light list learns of lights that come, go or change their type.

Everything else (moves, animation, sizes, switches) goes through drivers and needs no add-on. Nothing is written where
the file has no material of ours.
"""

from __future__ import annotations

from typing import Any

import bpy
from bpy.app.handlers import persistent
from mathutils import Vector

from .. import app_handlers, notices
from ..lights import emitters, gather, instances, light_list
from . import material, setup
from .node import eevee_output, group, migrate

#: What was said of each scene's lights, so that it is said once.
_said: dict[int, str] = {}
#: What decided in the last search whether the next is needed, by scene.
_quick: dict[int, tuple] = {}
#: Scenes with lights that no driver follows, which are written anew on each frame.
_written: set[int] = set()
#: What decided in the last search of a scene which lights it has (under 0: what glows), see `_needs_search`.
_looks: dict[int, tuple] = {}
#: Meshes that were found to glow, by scene.
_glowing: dict[int, set[int]] = {}
#: Names of all lamp objects of the file at the last search.
_lamps: list[str] = []
_at_work = False


def search(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> gather.Found:
    """The lights of a scene, those that light its objects of ours most first where there are too many."""
    if not instances.possible(scene):
        depsgraph = None
    elif depsgraph is None and bpy.context.scene == scene:
        depsgraph = bpy.context.view_layer.depsgraph
    return gather.search(scene, lambda: _places(scene), depsgraph)


def update_lights(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> bool:
    """Bring a scene's light list up to date; True if anything had to be written."""
    global _at_work
    if _at_work or not scene.is_editable or not material.any_ours():
        return False
    _at_work = True
    try:
        found = search(scene, depsgraph)
        changed = light_list.write(scene, found.chosen)
        _lamps[:] = [ob.name for ob in bpy.data.objects if ob.type == "LIGHT"]
        _quick[scene.as_pointer()] = _quick_look()
        _looks.update({scene.as_pointer(): _look(scene), 0: _glow()})
        _written.discard(scene.as_pointer())
        _glowing[scene.as_pointer()] = {_glowing_mesh(source) for source in (*found.chosen, *found.left_out)}
        if any(source.is_written for source in found.chosen):
            _written.add(scene.as_pointer())
        _say(scene, gather.too_many(found))
    finally:
        _at_work = False
    return changed


def _glowing_mesh(source: Any) -> int:
    """The object of a source that is a glowing mesh (`emitters`), 0 for others."""
    first = source.key[0]
    return first[1] if isinstance(first, tuple) and first[0] == "emitter" else 0


def update_all() -> None:
    """All scenes of the file."""
    for scene in bpy.data.scenes:
        update_lights(scene)


def _say(scene: bpy.types.Scene, text: str) -> None:
    before = _said.get(scene.as_pointer(), "")
    if text == before:
        return
    _said[scene.as_pointer()] = text
    if text and bpy.app.background:  # a window shows it in the panel
        print(f"Diffraction: {scene.name}: {text}.")
    state = getattr(scene, "diffraction", None)
    if state is not None and state.message in {"", before} and state.message != text:
        state.message = text


def _places(scene: bpy.types.Scene) -> list[Vector]:
    """Middles of the objects with a material of ours."""
    found: list[Any] = []
    for ob in scene.objects:
        if any(slot.material is not None and material.is_ours(slot.material) for slot in ob.material_slots):
            low, high = Vector(ob.bound_box[0]), Vector(ob.bound_box[6])
            found.append(ob.matrix_world @ (0.5 * (low + high)))
    return found


def _quick_look() -> tuple:
    """Changes whenever a lamp has come, gone, or was linked elsewhere; nothing here goes through all objects."""
    known = (bpy.data.objects.get(name) for name in _lamps)
    users = (ob.users if ob is not None else -1 for ob in known)
    return len(bpy.data.objects), *(light.users for light in bpy.data.lights), *users


@persistent
def _depsgraph_updated(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    if _at_work or not material.any_ours():
        return
    for update in depsgraph.updates:
        changed = update.id.original
        if isinstance(changed, bpy.types.Material) and changed.is_editable and changed.node_tree is not None:
            eevee_output.follow(changed.node_tree)
    if not _needs_search(depsgraph):
        return
    update_lights(scene, depsgraph)
    for each in bpy.data.scenes:
        if each != scene:
            update_lights(each)


def _needs_search(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether an update may be one of lights. What happens all the time is told from it without a search.

    A click that selects and a turn of a setting come as updates of the scene, every turn of a node as one of a tree.
    """
    scenes = trees = False
    for update in depsgraph.updates:
        known = update.id
        if isinstance(known, bpy.types.Object):
            if _may_light(known, update):
                return True
        elif isinstance(known, (bpy.types.Light, bpy.types.Collection, bpy.types.World)):
            return True
        if isinstance(known, bpy.types.Action) and _moves_a_world(known.original):
            return True
        scenes = scenes or isinstance(known, bpy.types.Scene)
        trees = trees or isinstance(known, (bpy.types.NodeTree, bpy.types.Material))
    if scenes and any(_looks.get(each.as_pointer()) != _look(each) for each in bpy.data.scenes if each.is_editable):
        return True
    return trees and _glow() != _looks.get(0)


def _moves_a_world(action: bpy.types.Action) -> bool:
    """Whether an action moves nodes of a world: keys of a sky are copied into the scene."""
    for world in bpy.data.worlds:
        for owner in (world, world.node_tree):
            if owner is not None and owner.animation_data is not None and owner.animation_data.action == action:
                return True
    return False


def _look(scene: bpy.types.Scene) -> tuple:
    """What of a scene itself decides its lights: which objects each layer has, world, set, working space."""
    layers = [(len(layer.objects), *_excluded(layer.layer_collection)) for layer in scene.view_layers]
    others = [each.as_pointer() if each is not None else 0 for each in (scene.world, scene.background_set)]
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "")
    return _quick_look(), layers, others, space


def _excluded(layer: bpy.types.LayerCollection) -> list[bool]:
    return [layer.exclude, *(flag for each in layer.children for flag in _excluded(each))]


def _glow() -> tuple:
    """Which materials glow, and how much."""
    found = ((each.as_pointer(), emitters.strength(each)) for each in bpy.data.materials)
    return tuple(pair for pair in found if pair[1] > 0.0)


def _may_light(ob: bpy.types.Object, update: bpy.types.DepsgraphUpdate) -> bool:
    """Whether an object's change may be one of lights: lamps, empties that show some, what makes instances or glows."""
    if ob.type in {"LIGHT", "EMPTY"}:
        return True
    if not update.is_updated_geometry:
        return False
    if _written or ob.instance_type != "NONE" or any(each.type in _MAKES_INSTANCES for each in ob.modifiers):
        return True
    if any(ob.original.as_pointer() in found for found in _glowing.values()):
        return True
    return any(slot.material is not None and emitters.strength(slot.material) > 0.0 for slot in ob.material_slots)


#: Modifiers that may show lamps as instances.
_MAKES_INSTANCES = {"NODES", "PARTICLE_SYSTEM"}


@persistent
def _file_loaded(*_: object) -> None:
    light_list.forget()
    _said.clear()
    _quick.clear()
    _written.clear()
    _glowing.clear()
    _looks.clear()
    group.follow_working_space()
    for sentence in migrate.migrate_all():
        notices.say(sentence)
    for sentence in setup.give_back_importance_sampling():
        notices.say(sentence)
    update_all()


@persistent
def _many(*_: object) -> None:
    group.follow_working_space()
    update_all()


@persistent
def _imported(*_: object) -> None:
    """After append, link and paste."""
    for sentence in migrate.migrate_all():
        notices.say(sentence)
    _many()


@persistent
def _render_begins(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    _after_others(scene, depsgraph)
    _go_last()


@persistent
def _rendering(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    """Before each frame of a render, after whatever other handlers did to the lamps."""
    _after_others(scene, depsgraph)


@persistent
def _frame_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    if scene.as_pointer() in _written or _quick.get(scene.as_pointer()) != _quick_look():
        _after_others(scene, depsgraph)


def _after_others(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None) -> None:
    """Handlers of others may have made lamps, which Blender has not placed yet."""
    global _at_work
    if _at_work or not material.any_ours():
        return
    known = _quick.get(scene.as_pointer())
    if known is not None and known != _quick_look():
        _at_work = True
        try:
            for layer in scene.view_layers:
                layer.update()
        finally:
            _at_work = False
    update_lights(scene, depsgraph)


_HANDLERS = (
    ("depsgraph_update_post", _depsgraph_updated),
    ("load_post", _file_loaded),
    ("save_pre", _many),
    ("blend_import_post", _imported),
    ("render_init", _render_begins),
    ("render_pre", _rendering),
    ("frame_change_post", _frame_changed),
)


def _go_last() -> None:
    """Behind handlers that were added later, which may still add or switch lamps.

    Called when Blender goes through none of these lists: it would pass over whoever takes the place of one that moved.
    """
    for name in ("render_pre", "frame_change_post"):
        where = getattr(bpy.app.handlers, name)
        ours = next(handler for each, handler in _HANDLERS if each == name)
        if where and where[-1] is not ours and ours in where:
            where.remove(ours)
            where.append(ours)


def register() -> None:
    """Begin to follow."""
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    """Stop."""
    app_handlers.remove(_HANDLERS)
    light_list.forget()
