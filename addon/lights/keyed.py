# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyframes for lights that Python has to write on each frame, so that a farm needs no extension for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import bpy

from . import animated, light_list, slots


def bake(scene: bpy.types.Scene, frames: Sequence[int], write: Callable[[], object]) -> int:
    """Key what no driver follows; gives the number of slots that got keys.

    Slots that are empty on some frames are dark there. Keys of an earlier call go first.

    Parameters
    ----------
    scene
        Editable; it stays at the frame where it was.
    frames
        To key.
    write
        Brings the scene's list up to date at its present frame.
    """
    clear(scene)
    before = scene.frame_current, scene.frame_subframe
    seen: list[dict[str, list[float]]] = []
    numbered: list[int] = []
    wanted: set[int] = set()
    try:
        for frame in frames:
            scene.frame_set(frame)
            write()
            wanted |= light_list.written_slots(scene)
            seen.append({name: list(scene[name]) for slot in range(1, slots.SLOTS + 1) for name in slots.names(slot)})
            numbered.append(int(scene[slots.COUNT]))
    finally:
        scene.frame_set(before[0], subframe=before[1])
    for slot in sorted(wanted):
        for name in slots.names(slot):
            for frame, values in zip(frames, seen, strict=True):
                scene[name] = values[name]
                scene.keyframe_insert(f'["{name}"]', frame=frame)
    if wanted:
        for frame, count in zip(frames, numbered, strict=True):
            scene[slots.COUNT] = count
            scene.keyframe_insert(f'["{slots.COUNT}"]', frame=frame)
    for curve in _curves(scene):
        jumps = curve.data_path == f'["{slots.COUNT}"]' or curve.array_index == 3
        for key in curve.keyframe_points:
            key.interpolation = "CONSTANT" if jumps else "LINEAR"
    scene.frame_set(before[0], subframe=before[1])
    return len(wanted)


def clear(scene: bpy.types.Scene) -> bool:
    """Take such keys away; True if there were any."""
    curves = _curves(scene)
    for path in {curve.data_path for curve in curves}:
        for bag in animated.bags(scene):
            for curve in [curve for curve in bag.fcurves if curve.data_path == path]:
                bag.fcurves.remove(curve)
    return bool(curves)


def is_baked(scene: bpy.types.Scene) -> bool:
    """Whether a scene has such keys."""
    return bool(_curves(scene))


def _curves(scene: bpy.types.Scene) -> list[bpy.types.FCurve]:
    paths = {f'["{name}"]' for slot in range(1, slots.SLOTS + 1) for name in slots.names(slot)}
    paths.add(f'["{slots.COUNT}"]')
    return [curve for bag in animated.bags(scene) for curve in bag.fcurves if curve.data_path in paths]
