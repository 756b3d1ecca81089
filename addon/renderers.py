# SPDX-License-Identifier: GPL-3.0-or-later
"""Which implementation of the material a scene can render here, and why."""

from __future__ import annotations

import bpy

from .versions import EEVEE

#: Devices of Cycles that run OSL beside the processor.
_GPU_WITH_OSL = {"OPTIX"}


def has_osl() -> bool:
    """Whether this Blender was built with Open Shading Language, which Linux distributions leave out."""
    try:
        import _cycles
    except ImportError:
        return False
    return bool(getattr(_cycles, "with_osl", False))


def device_without_osl(scene: bpy.types.Scene) -> str:
    """The GPU interface that a scene renders with, where that runs no OSL; else empty."""
    cycles = getattr(scene, "cycles", None)
    addon = bpy.context.preferences.addons.get("cycles")
    if cycles is None or addon is None or cycles.device != "GPU":
        return ""
    kind = addon.preferences.compute_device_type
    return "" if kind == "NONE" or kind in _GPU_WITH_OSL else kind


def why_not_osl(scene: bpy.types.Scene) -> str:
    """Why a scene cannot render an OSL material with its engine and device; empty where it can."""
    if not has_osl():
        return "this Blender was built without Open Shading Language"
    if scene.render.engine != "CYCLES":
        return f"the scene renders with {engine_name(scene)}"
    device = device_without_osl(scene)
    return f"{device} runs no Open Shading Language" if device else ""


def choose(scene: bpy.types.Scene, background: bool | None = None) -> tuple[str, str]:
    """What *Automatic* stands for in a scene: ``OSL`` or ``NODES``, and why.

    Without a window a script may set engine and device later, so there OSL is taken where this Blender has it.
    """
    if background is None:
        background = bpy.app.background
    if background:
        why_not = "" if has_osl() else why_not_osl(scene)
    else:
        why_not = why_not_osl(scene)
    return ("NODES", why_not) if why_not else ("OSL", "Cycles runs it here")


def engine_name(scene: bpy.types.Scene) -> str:
    """An engine's name for people."""
    return {EEVEE: "EEVEE", "CYCLES": "Cycles", "BLENDER_WORKBENCH": "Workbench"}.get(
        scene.render.engine, scene.render.engine.title()
    )
