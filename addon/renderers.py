# SPDX-License-Identifier: GPL-3.0-or-later
"""Which implementation of the material a scene can render here, and why."""

from __future__ import annotations

import bpy

from .versions import EEVEE

#: Devices of Cycles that run OSL beside the processor.
_GPU_WITH_OSL = {"OPTIX"}

#: Where Cycles on OptiX keeps all closures of an OSL shader; it does not check, see `materials.closures`.
OPTIX_BYTES = 1024


def has_osl() -> bool:
    """Whether this Blender was built with Open Shading Language, which Linux distributions leave out."""
    try:
        import _cycles
    except ImportError:
        return False
    return bool(getattr(_cycles, "with_osl", False))


def _gpu(scene: bpy.types.Scene) -> str:
    """The GPU interface that a scene renders with, empty where that is the processor."""
    cycles = getattr(scene, "cycles", None)
    addon = bpy.context.preferences.addons.get("cycles")
    if cycles is None or addon is None or cycles.device != "GPU":
        return ""
    kind = addon.preferences.compute_device_type
    return "" if kind == "NONE" else kind


def device_without_osl(scene: bpy.types.Scene) -> str:
    """The GPU interface that a scene renders with, where that runs no OSL; else empty."""
    kind = _gpu(scene)
    return "" if kind in _GPU_WITH_OSL else kind


def on_optix(scene: bpy.types.Scene) -> bool:
    """Whether a scene renders with Cycles on OptiX."""
    return scene.render.engine == "CYCLES" and _gpu(scene) == "OPTIX"


def past_optix(scene: bpy.types.Scene, closure_bytes: int) -> str:
    """Why OptiX would not render an OSL material of so many bytes of closures whole; empty where it does."""
    if not on_optix(scene) or closure_bytes <= OPTIX_BYTES:
        return ""
    return f"with this scene's lamps it takes {closure_bytes:,} bytes of closures, and OptiX keeps {OPTIX_BYTES:,}"


def why_not_osl(scene: bpy.types.Scene) -> str:
    """Why a scene cannot render an OSL material with its engine and device; empty where it can."""
    if not has_osl():
        return "this Blender was built without Open Shading Language"
    if scene.render.engine != "CYCLES":
        return f"the scene renders with {engine_name(scene)}"
    device = device_without_osl(scene)
    return f"{device} runs no Open Shading Language" if device else ""


def choose(scene: bpy.types.Scene, background: bool | None = None, closure_bytes: int = 0) -> tuple[str, str]:
    """What *Automatic* stands for in a scene: ``OSL`` or ``NODES``, and why.

    Without a window a script may set engine and device later, so there OSL is taken where this Blender has it, and no
    OptiX that is set already lacks room for it.

    Parameters
    ----------
    scene
        That will be rendered.
    background
        Whether there is no window; None asks Blender.
    closure_bytes
        What the materials take in OSL (`materials.closures`).
    """
    if background is None:
        background = bpy.app.background
    if background:
        why_not = "" if has_osl() else why_not_osl(scene)
    else:
        why_not = why_not_osl(scene)
    why_not = why_not or past_optix(scene, closure_bytes)
    return ("NODES", why_not) if why_not else ("OSL", "Cycles runs it here")


def engine_name(scene: bpy.types.Scene) -> str:
    """An engine's name for people."""
    return {EEVEE: "EEVEE", "CYCLES": "Cycles", "BLENDER_WORKBENCH": "Workbench"}.get(
        scene.render.engine, scene.render.engine.title()
    )
