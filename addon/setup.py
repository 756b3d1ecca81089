# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene settings that the method needs: set visibly, remembered, and given back on request."""

from __future__ import annotations

import json

import bpy

#: Custom property of scenes and lamps that holds what was there before.
BEFORE = "diffraction_before"


def prepare_scene(scene: bpy.types.Scene, lamps: list[bpy.types.Object], needs_osl: bool = True) -> list[str]:
    """Set what Cycles needs and say what was changed, one sentence without a full stop each.

    * OSL on (CPU and OptiX), where a material has it;
    * multiple importance sampling off for lamps: aimed lobes are found by sampling the lamp, a ray that
      finds the lamp by chance only adds noise.
    """
    notes = []
    cycles = getattr(scene, "cycles", None)
    if needs_osl and cycles is not None and not cycles.shading_system:
        _remember(scene, "shading_system", False)
        cycles.shading_system = True
        notes.append("Open Shading Language is on for this scene")
    if scene.render.engine not in {"CYCLES", "BLENDER_EEVEE", "BLENDER_WORKBENCH"}:
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


def restore_scene(scene: bpy.types.Scene) -> int:
    """Give back what `prepare_scene` changed, in this scene and in all lamps; the number of things changed."""
    count = 0
    for owner in (scene, *bpy.data.lights):
        before = json.loads(owner.get(BEFORE, "{}"))
        if "shading_system" in before:
            owner.cycles.shading_system = before["shading_system"]
        if "mis" in before:
            owner.cycles.use_multiple_importance_sampling = before["mis"]
        if before:
            del owner[BEFORE]
            count += 1
    return count


def _remember(owner: bpy.types.ID, key: str, value: bool) -> None:
    before = json.loads(owner.get(BEFORE, "{}"))
    before.setdefault(key, value)
    owner[BEFORE] = json.dumps(before, sort_keys=True)
