# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that the engine, the device or the settings of a scene do not render."""

from __future__ import annotations

import bpy

from .. import renderers
from ..materials import closures, material


def misfits(scene: bpy.types.Scene) -> list[bpy.types.Material]:
    """Materials on the scene's objects that its engine or device does not render as diffraction."""
    is_run = not renderers.why_not_osl(scene) and _osl_is_on(scene)
    if is_run and not renderers.on_optix(scene):
        return []
    if not any(material.needs_osl(each) for each in material.of_file()):
        return []
    found = {
        slot.material: None
        for ob in scene.objects
        for slot in ob.material_slots
        if material.is_ours(slot.material) and material.shader_node(slot.material) is not None
    }
    return [each for each in found if material.needs_osl(each) and not (is_run and closures.fits_optix(each, scene))]


def why(scene: bpy.types.Scene) -> str:
    """Why those do not fit, as a sentence."""
    if renderers.on_optix(scene) and _osl_is_on(scene):
        return "OptiX has no room for so many lamps in OSL: some of their colours would be missing"
    reason = renderers.why_not_osl(scene) or "Open Shading Language is off for this scene"
    return f"{reason[0].upper()}{reason[1:]}: OSL materials show no diffraction"


def _osl_is_on(scene: bpy.types.Scene) -> bool:
    cycles = getattr(scene, "cycles", None)
    return cycles is None or bool(cycles.shading_system)
