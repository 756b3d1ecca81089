# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings that the method needs: set visibly, remembered, and given back on request."""

from __future__ import annotations

import json
from collections.abc import Sequence

import bpy

from ..versions import EEVEE
from .lights import LampObject

#: Custom property of scenes, lamps and materials that holds what was there before.
BEFORE = "diffraction_before"

#: Custom property of a scene whose settings were given back: they stay so until a material is applied again.
HANDS_OFF = "diffraction_hands_off"


def take_up(scene: bpy.types.Scene) -> None:
    """The user asks for the settings: what was given back may be set again."""
    if HANDS_OFF in scene:
        del scene[HANDS_OFF]


def prepare_scene(scene: bpy.types.Scene, lamps: Sequence[LampObject], needs_osl: bool = True) -> list[str]:
    """Set what Cycles needs and say what was changed, one sentence without a full stop each.

    * OSL on (CPU and OptiX), where a material has it;
    * multiple importance sampling off for lamps: aimed lobes are found by sampling the lamp, a ray that
      finds the lamp by chance only adds noise.

    Lamps of libraries stay as they are, and so does all after `restore_scene` until `take_up`.
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
    changed = 0
    for light in {lamp.data for lamp in lamps}:
        settings = getattr(light, "cycles", None)
        if settings is not None and light.is_editable and settings.use_multiple_importance_sampling:
            _remember(light, "mis", True)
            settings.use_multiple_importance_sampling = False
            changed += 1
    if changed:
        notes.append(f"Multiple importance sampling is off for {changed} lamp{'s' * (changed != 1)}")
    return notes


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
    for owners, what, noun in (
        (bpy.data.lights, "Multiple importance sampling off", "lamp"),
        (bpy.data.materials, "Bump map correction off", "material"),
    ):
        count = sum(bool(_before(owner)) for owner in owners)
        if count:
            found.append(f"{what}: {count} {noun}{'s' * (count != 1)}")
    return found


def restore_scene(scene: bpy.types.Scene) -> int:
    """Give back what was changed, in this scene and in all lamps and materials; the number of things changed.

    Nothing is set again by itself until `take_up`.
    """
    count = 0
    for owner in (scene, *bpy.data.lights, *bpy.data.materials):
        before = _before(owner)
        if not before or not owner.is_editable:
            continue
        if "shading_system" in before:
            owner.cycles.shading_system = before["shading_system"]
        if "mis" in before:
            owner.cycles.use_multiple_importance_sampling = before["mis"]
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
