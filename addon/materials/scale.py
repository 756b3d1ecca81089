# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the scan's physical size means anything on an object of this size in a scene of these units."""

from __future__ import annotations

import bpy

#: A surface of fewer coherence windows than this shows no BRDF, but single speckles.
_WINDOWS_MIN = 10.0

#: A pixel that covers more windows than this a side sees their average and not one of them.
_WINDOWS_A_PIXEL = 4.0


def warnings(
    scene: bpy.types.Scene, ob: bpy.types.Object | None, ensemble: str, sigma_s_m: float, patch_m: float
) -> list[str]:
    """Sentences on the scale of an object; empty where all is well.

    A table is a BRDF: it says what a place of the surface does that is much larger than the coherence window and much
    smaller than anything that is looked at. Under ``single`` the speckles of one window are painted on the whole
    object, which only a picture of a window's size justifies.

    Parameters
    ----------
    scene
        Its unit scale counts; without units one unit is a metre.
    ob
        The object that diffracts.
    ensemble
        ``average`` or ``single``.
    sigma_s_m, patch_m
        Coherence window and side of the patch, metres; 0 where unknown.
    """
    if ob is None or not hasattr(ob, "dimensions") or max(ob.dimensions) <= 0.0:
        return []
    units = scene.unit_settings
    metres = units.scale_length if units.system != "NONE" else 1.0
    size = max(ob.dimensions) * metres
    window = max(2.0 * sigma_s_m, 1e-9)
    found = []
    if size < _WINDOWS_MIN * window:
        found.append(
            f"{ob.name} is {length(size)} long, hardly more than the coherence window of {length(window)}: a BRDF means"
            " nothing there. Check the unit scale or the size"
        )
    elif patch_m and size < patch_m:
        found.append(f"{ob.name} is {length(size)} long, smaller than the scanned patch of {length(patch_m)}")
    resolution = max(scene.render.resolution_x, scene.render.resolution_y) * scene.render.resolution_percentage / 100.0
    pixel = size / max(resolution, 1.0)
    if ensemble == "single" and pixel > _WINDOWS_A_PIXEL * window:
        found.append(
            f"'Single' shows one window of {length(window)}, but a pixel covers about {length(pixel)} of {ob.name}:"
            " take 'Average'"
        )
    return found


def length(metres: float) -> str:
    """A length as people say it."""
    for factor, unit in ((1.0, "m"), (1e-3, "mm"), (1e-6, "um")):
        if metres >= 0.9995 * factor:
            return f"{metres / factor:.3g} {unit}"
    return f"{metres * 1e9:.3g} nm"
