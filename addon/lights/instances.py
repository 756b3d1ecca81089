# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that the depsgraph makes: instances by geometry nodes, vertices, faces and particles.

No driver can follow them, so Python writes their numbers on each frame, and only where a search found some.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from . import lamps
from .slots import KINDS
from .source import Source


def possible(scene: bpy.types.Scene) -> bool:
    """Whether a scene may hold such instances; quick where it has no lamp at all."""
    if not bpy.data.lights:
        return False
    for each in lamps.with_sets(scene):
        for ob in each.objects:
            if ob.instance_type in {"VERTS", "FACES"} or ob.particle_systems:
                return True
            if ob.type != "LIGHT" and any(modifier.type == "NODES" for modifier in ob.modifiers):
                return True
    return False


def is_made_lamp(instance: bpy.types.DepsgraphObjectInstance) -> bool:
    """Whether an instance is a lamp; those of collections that empties show are lamps of the scene's and left out."""
    if not instance.is_instance or instance.object.type != "LIGHT":
        return False
    parent = instance.parent
    if parent is None or (parent.type == "EMPTY" and parent.instance_type == "COLLECTION"):
        return False
    return not lamps.is_portal(instance.object.data) and not instance.object.original.hide_render


def sources(depsgraph: bpy.types.Depsgraph) -> Iterator[Source]:
    """Instanced lamps as they stand now."""
    for instance in depsgraph.object_instances:
        if not is_made_lamp(instance):
            continue
        ob, light, world = instance.object, instance.object.data, instance.matrix_world
        parent: Any = instance.parent
        kind = lamps.lamp_kind(light)
        place = world.col[2].xyz if kind == "SUN" else world.translation
        u, v, size = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), lamps.sizes(light)[0]
        if light.type == "AREA":
            halves = [0.5 * side for side in lamps.sizes(light)]
            u, v = (tuple(half * world.col[i].xyz) for i, half in enumerate(halves))
            size = light.spread
        uneven = float(lamps.is_uneven(light))
        name = f"{parent.name}: {ob.name}"
        yield Source(
            key=(("instance", parent.original.as_pointer(), *instance.persistent_id), name),
            name=name,
            kind=kind,
            entries=(*place, float(KINDS[kind]), *u, float(size), *v, uneven),
            strength=lamps.power_at(light, world),
            is_written=True,
        )
