# SPDX-License-Identifier: GPL-3.0-or-later
"""All that is wrong with a scene's diffraction, and its way to the console before a render."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
from bpy.app.handlers import persistent

from .. import app_handlers
from ..materials import material
from . import images, misfits, places, texture_limit


def before_render(scene: bpy.types.Scene) -> list[str]:
    """Sentences without a full stop on whatever keeps a render of a scene from its colours."""
    if not material.any_ours():
        return []
    found = [f"{each.name}: {text}" for each, text in places.problems()]
    unfit = misfits.misfits(scene)
    if unfit:
        found.append(f"{misfits.why(scene)}: {', '.join(each.name for each in unfit)}")
    return [*found, *texture_limit.sentences(scene, viewport=False), *images.sentences(thorough=True)]


def in_panels(scene: bpy.types.Scene) -> Iterator[str]:
    """What no other panel says, cheap enough for each redraw."""
    if material.any_ours():
        yield from texture_limit.sentences(scene)
        yield from images.sentences()


@persistent
def _rendering(scene: bpy.types.Scene, *_: object) -> None:
    for sentence in before_render(scene):
        print(f"Diffraction: {scene.name}: {sentence}.", flush=True)


_HANDLERS = (("render_init", _rendering),)


def register() -> None:
    """Begin to say it."""
    app_handlers.add(_HANDLERS)


def unregister() -> None:
    """Stop."""
    app_handlers.remove(_HANDLERS)
