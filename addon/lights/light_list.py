# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes a scene's light list: custom properties and the drivers on them.

The list is saved with the file and needs no add-on to be followed: drivers copy single numbers or use simple
expressions, which run with scripts switched off. What drivers cannot follow (instances that the depsgraph makes) is
written by Python, and then `bpy.types.Scene.update_tag` has to tell the renderers.
"""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ...precompute.errors import ParameterError
from ...precompute.light.colour import xyz_to_rgb_matrix
from ..colour_spaces import working_space
from . import slots
from .animated import Copied
from .source import Drive, Entry, Source

#: Keys of the sources by scene and slot, as they were last written in this session.
_written: dict[int, dict[int, Source]] = {}


def forget() -> None:
    """Another file is open: what is there has to be read anew."""
    _written.clear()


def has_list(scene: bpy.types.Scene) -> bool:
    """Whether a scene has a list, which may be empty."""
    return slots.COUNT in scene


def remove(scene: bpy.types.Scene) -> None:
    """Take a scene's list away with its drivers; its surfaces then show their pigment alone."""
    _written.pop(scene.as_pointer(), None)
    for name in [*_names(scene)]:
        _undrive(scene, name)
        del scene[name]
    scene.update_tag()


def _names(scene: bpy.types.Scene) -> list[str]:
    """All custom properties of the list."""
    own = {slots.COUNT, *slots.MATRIX, *(name for slot in range(1, slots.SLOTS + 1) for name in slots.names(slot))}
    return [name for name in list(scene.keys()) if name in own or name.startswith(slots.FRAME)]


def write(scene: bpy.types.Scene, sources: Sequence[Source]) -> bool:
    """Bring a scene's list up to date; True if anything had to be written.

    Parameters
    ----------
    scene
        Editable.
    sources
        At most `slots.SLOTS`; a source that has a slot keeps it.
    """
    before = _written.get(scene.as_pointer())
    fresh = before is None
    placed = _place(before or {}, sources)
    changed = False
    frames = {name: entries for source in sources for name, entries in source.frames.items()}
    for name, entries in frames.items():
        if fresh or name not in scene:
            _put(scene, name, entries)
            changed = True
    for slot in range(1, slots.SLOTS + 1):
        source, old = placed.get(slot), (before or {}).get(slot)
        names = slots.names(slot)
        if source is None:
            if fresh or old is not None or names[0] not in scene:
                for name in names:
                    _put(scene, name, (0.0,) * 4)
                changed = True
            continue
        if fresh or old is None or old.key != source.key:
            for part, name in enumerate(names):
                _put(scene, name, source.entries[4 * part : 4 * part + 4])
            changed = True
        elif source.is_written:
            for part, name in enumerate(names):
                changed |= _set(
                    scene, name, [x for x in source.entries[4 * part : 4 * part + 4] if not isinstance(x, Drive)]
                )
    for name in [n for n in list(scene.keys()) if n.startswith(slots.FRAME) and n not in frames]:
        _undrive(scene, name)
        del scene[name]
        changed = True
    last = max(placed, default=0)
    if scene.get(slots.COUNT) != last:
        scene[slots.COUNT] = last
        changed = True
    changed |= _write_matrix(scene)
    _written[scene.as_pointer()] = placed
    if changed:
        scene.update_tag()
    return changed


def written_slots(scene: bpy.types.Scene) -> set[int]:
    """Slots whose lights no driver follows, as the list was last written."""
    return {slot for slot, source in _written.get(scene.as_pointer(), {}).items() if source.is_written}


def _write_matrix(scene: bpy.types.Scene) -> bool:
    try:
        rows = xyz_to_rgb_matrix(working_space())
    except ParameterError:  # a space that is not known here: whoever bakes or applies is told
        return False
    return any([_set(scene, name, [float(x) for x in row]) for name, row in zip(slots.MATRIX, rows, strict=True)])


def _place(before: dict[int, Source], sources: Sequence[Source]) -> dict[int, Source]:
    """Slots of the sources: each stays where it is, new ones take what is free."""
    held = {source.key: slot for slot, source in before.items()}
    placed: dict[int, Source] = {}
    new = []
    for source in sources:
        slot = held.get(source.key)
        if slot is None or slot in placed or slot > len(sources):
            new.append(source)
        else:
            placed[slot] = source
    free = iter(slot for slot in range(1, slots.SLOTS + 1) if slot not in placed)
    for source in new:
        placed[next(free)] = source
    return placed


def _put(scene: bpy.types.Scene, name: str, entries: Sequence[Entry]) -> None:
    """A property anew: values, and drivers where entries follow something."""
    _undrive(scene, name)
    _set(scene, name, [entry.value() if isinstance(entry, Drive) else float(entry) for entry in entries])
    for index, entry in enumerate(entries):
        if isinstance(entry, Drive):
            _drive(scene, name, index, entry)


def _set(scene: bpy.types.Scene, name: str, values: list[float]) -> bool:
    there = scene.get(name)
    if there is not None and len(there) == len(values) and list(there) == values:
        return False
    scene[name] = values
    return True


def _undrive(scene: bpy.types.Scene, name: str) -> None:
    animation = scene.animation_data
    if animation is None:
        return
    path = f'["{name}"]'
    for curve in [curve for curve in animation.drivers if curve.data_path == path]:
        animation.drivers.remove(curve)


def _drive(scene: bpy.types.Scene, name: str, index: int, entry: Drive) -> None:
    curve = scene.driver_add(f'["{name}"]', index)
    if isinstance(entry, Copied):
        entry.onto(curve)
        return
    driver = curve.driver
    driver.type = "SCRIPTED" if entry.expression else "SUM"
    for each in entry.variables:
        variable = driver.variables.new()
        variable.name = each.name
        variable.type = "SINGLE_PROP"
        target = variable.targets[0]
        target.id_type = _id_type(each.owner)
        target.id = each.owner
        target.data_path = each.path
    if entry.expression:
        driver.expression = entry.expression


def _id_type(owner: bpy.types.ID) -> str:
    if isinstance(owner, bpy.types.Light):
        return "LIGHT"
    if isinstance(owner, bpy.types.ShaderNodeTree):
        return "NODETREE"
    for kind in ("Object", "Scene", "World", "Material"):
        if isinstance(owner, getattr(bpy.types, kind)):
            return kind.upper()
    raise TypeError(f"No driver can follow a {type(owner).__name__}.")
