# SPDX-License-Identifier: GPL-3.0-or-later
"""All lights of a scene that get a slot of its list, and those for which none is left."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import bpy
from mathutils import Vector

from . import lamps
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


def search(scene: bpy.types.Scene, places: Callable[[], Sequence[Vector]]) -> Found:
    """The lights of a scene.

    Parameters
    ----------
    scene
        With its set scenes.
    places
        Gives world positions of what is lit; asked only where there are too many lights.
    """
    shining = [lamps.source(scene, lamp) for lamp in lamps.lamp_objects(scene)]
    if len(shining) > SLOTS:
        shining = _brightest_first(scene, places() or [Vector((0.0, 0.0, 0.0))])
    chosen = shining[:SLOTS]
    if len(chosen) < SLOTS:  # a script may switch these on in the middle of a render: drivers follow that
        dark = lamps.switched_off(scene)[: SLOTS - len(chosen)]
        chosen = chosen + [lamps.source(scene, lamp) for lamp in dark]
    return Found(chosen, shining[SLOTS:])


def _brightest_first(scene: bpy.types.Scene, places: Sequence[Vector]) -> list[Source]:
    found = []
    for lamp in lamps.lamp_objects(scene):
        strength = max(lamps.irradiance(lamp, place) for place in places)
        found.append(dataclasses.replace(lamps.source(scene, lamp), strength=strength))
    return sorted(found, key=lambda source: -source.strength)


def too_many(found: Found) -> str:
    """The sentence on lights without a slot, without a full stop; empty where there are none."""
    if not found.left_out:
        return ""
    names = ", ".join(source.name for source in found.left_out)
    return (
        f"{len(found.chosen) + len(found.left_out)} lights, of which the {SLOTS} brightest are diffracted: not {names}"
    )
