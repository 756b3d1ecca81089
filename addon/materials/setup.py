# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that the method needs: set visibly, remembered, and given back on request."""

from __future__ import annotations

import json

import bpy

from ..versions import EEVEE

#: Custom property of scenes and materials (of version 0.1.0 of lamps too) that holds what was there before.
BEFORE = "diffraction_before"

#: Custom property of a scene whose settings were given back: they stay so until a material is applied again.
HANDS_OFF = "diffraction_hands_off"


def take_up(scene: bpy.types.Scene) -> None:
    """The user asks for the settings: what was given back may be set again."""
    if HANDS_OFF in scene:
        del scene[HANDS_OFF]


def prepare_scene(scene: bpy.types.Scene, needs_osl: bool = True) -> list[str]:
    """Switch OSL on where a material needs it and say what was changed, one sentence without a full stop each.

    All stays as it is after `restore_scene` until `take_up`.
    """
    if HANDS_OFF in scene:
        return []
    notes = []
    cycles = getattr(scene, "cycles", None)
    if needs_osl and cycles is not None and not cycles.shading_system:
        _remember(scene, "shading_system", False)
        cycles.shading_system = True
        notes.append("Open Shading Language is on for this scene")
    if scene.render.engine not in {"CYCLES", EEVEE, "BLENDER_WORKBENCH"}:
        notes.append("The scene's renderer is not Cycles, which this material needs")
    return notes


def give_back_importance_sampling() -> list[str]:
    """Lamps whose multiple importance sampling version 0.1.0 switched off get it back; one sentence each kind.

    Other materials live on it, mirrors and glass above all. Lamps of libraries are named: only their own files
    can be mended.
    """
    own, linked = [], []
    for light in bpy.data.lights:
        before = _before(light)
        if "mis" not in before:
            continue
        settings = getattr(light, "cycles", None)
        was_off = settings is not None and settings.use_multiple_importance_sampling != before["mis"]
        if not light.is_editable:
            linked += [light.name] if was_off else []
            continue
        before_value = before.pop("mis")
        if settings is not None and was_off:
            settings.use_multiple_importance_sampling = before_value
            own.append(light.name)
        if before:
            light[BEFORE] = json.dumps(before, sort_keys=True)
        else:
            del light[BEFORE]
    found = []
    if own:
        found.append(
            f"Multiple importance sampling, which version 0.1.0 had switched off, is on again: {', '.join(own)}"
        )
    if linked:
        found.append(
            f"Multiple importance sampling is off for linked lamps, which mirrors then miss: {', '.join(linked)};"
            " open and save their files with this version"
        )
    return found


def prepare_material(material: bpy.types.Material) -> None:
    """Bump map correction off: it bends the half vectors that stand in for normals."""
    if material.cycles.use_bump_map_correction and not any(HANDS_OFF in scene for scene in bpy.data.scenes):
        _remember(material, "bump_correction", True)
        material.cycles.use_bump_map_correction = False


def changes(scene: bpy.types.Scene) -> list[str]:
    """What is set now and was not before, for the panel."""
    found = []
    if "shading_system" in _before(scene):
        found.append("Open Shading Language on")
    count = sum(bool(_before(each)) for each in bpy.data.materials)
    if count:
        found.append(f"Bump map correction off: {count} material{'s' * (count != 1)}")
    return found


def restore_scene(scene: bpy.types.Scene) -> int:
    """Give back what was changed, in this scene and in all materials; the number of things changed.

    Nothing is set again by itself until `take_up`.
    """
    count = 0
    for owner in (scene, *bpy.data.materials):
        before = _before(owner)
        if not before or not owner.is_editable:
            continue
        if "shading_system" in before:
            owner.cycles.shading_system = before["shading_system"]
        if "bump_correction" in before:
            owner.cycles.use_bump_map_correction = before["bump_correction"]
        del owner[BEFORE]
        count += 1
    scene[HANDS_OFF] = True
    return count


def _before(owner: bpy.types.ID) -> dict[str, bool]:
    return json.loads(owner.get(BEFORE, "{}"))


def _remember(owner: bpy.types.ID, key: str, value: bool) -> None:
    before = _before(owner)
    before.setdefault(key, value)
    owner[BEFORE] = json.dumps(before, sort_keys=True)
