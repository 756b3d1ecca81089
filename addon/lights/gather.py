# SPDX-License-Identifier: GPL-3.0-or-later
"""All lights of a scene that get a slot of its list, and those for which none is left."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import bpy
from mathutils import Vector

from . import emitters, instances, lamps, worlds
from .slots import SLOTS
from .source import Source


@dataclass(frozen=True)
class Found:
    """What a search brought.

    Parameters
    ----------
    chosen
        At most `SLOTS`.
    left_out
        Further ones that shine, brightest first.
    """

    chosen: list[Source]
    left_out: list[Source]


def search(
    scene: bpy.types.Scene, places: Callable[[], Sequence[Vector]], depsgraph: bpy.types.Depsgraph | None = None
) -> Found:
    """The lights of a scene.

    Parameters
    ----------
    scene
        With its set scenes.
    places
        Gives world positions of what is lit; asked only where there are too many lights.
    depsgraph
        Whose instances to look through; None takes none of them.
    """
    objects = lamps.lamp_objects(scene)
    others = [*worlds.sources(scene), *emitters.sources(scene)]
    if depsgraph is not None:
        others += instances.sources(depsgraph)
    shining = [*(lamps.source(scene, lamp) for lamp in objects), *others]
    if len(shining) > SLOTS:
        lit = places() or [Vector((0.0, 0.0, 0.0))]
        strengths = [max(lamps.irradiance(lamp, place) for place in lit) for lamp in objects]
        strengths += [source.strength for source in others]
        order = sorted(range(len(shining)), key=lambda i: -strengths[i])
        shining = [shining[i] for i in order]
    chosen = shining[:SLOTS]
    if len(chosen) < SLOTS:  # a script may switch these on in the middle of a render: drivers follow that
        dark = lamps.switched_off(scene)[: SLOTS - len(chosen)]
        chosen = chosen + [lamps.source(scene, lamp) for lamp in dark]
    return Found(chosen, shining[SLOTS:])


def too_many(found: Found) -> str:
    """The sentence on lights without a slot, without a full stop; empty where there are none."""
    if not found.left_out:
        return ""
    names = ", ".join(source.name for source in found.left_out)
    return (
        f"{len(found.chosen) + len(found.left_out)} lights, of which the {SLOTS} brightest are diffracted: not {names}"
    )
