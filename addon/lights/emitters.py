# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes that glow: Cycles samples them as lights, so each gets a ball that holds it and follows its object."""

from __future__ import annotations

import math
from collections.abc import Iterator

import bpy
import numpy as np
from mathutils import Vector

from . import lamps
from .slots import KINDS
from .source import Drive, Entry, Source, Variable

#: Middle and radius of meshes by identity, with what they depended on.
_balls: dict[int, tuple[tuple, Vector, float]] = {}


def sources(scene: bpy.types.Scene) -> Iterator[Source]:
    """Glowing meshes of a scene and its set scenes."""
    glowing = {material for material in bpy.data.materials if strength(material) > 0.0}
    if not glowing:
        return
    for each in lamps.with_sets(scene):
        for ob in each.objects:
            if ob.type == "MESH" and lamps.shows(ob):
                found = [slot.material for slot in ob.material_slots if slot.material in glowing]
                if found:
                    yield _source(ob, max(strength(material) for material in found))


def strength(material: bpy.types.Material) -> float:
    """Radiance of what glows in a material, as far as its nodes tell: emission of the top level; 0 if none counts."""
    tree = material.node_tree
    if tree is None or getattr(getattr(material, "cycles", None), "emission_sampling", "AUTO") == "NONE":
        return 0.0
    most = 0.0
    for node in tree.nodes:
        names = {
            "ShaderNodeEmission": ("Color", "Strength"),
            "ShaderNodeBsdfPrincipled": ("Emission Color", "Emission Strength"),
        }.get(node.bl_idname)
        if names is None or node.mute or not node.outputs[0].links:
            continue
        colour, number = (node.inputs[name] for name in names)
        power = 1.0 if number.links else number.default_value
        if not colour.links:
            power *= sum(colour.default_value[:3]) / 3.0
        elif node.bl_idname == "ShaderNodeBsdfPrincipled" and not number.links and number.default_value == 0.0:
            power = 0.0
        most = max(most, power)
    return most


def _source(ob: bpy.types.Object, radiance: float) -> Source:
    middle, radius = _ball(ob)
    place: list[Entry] = []
    for axis in range(3):
        variables = tuple(Variable(f"m{k}", ob, f"matrix_world[{k}][{axis}]") for k in range(4))
        terms = "+".join(f"m{k}*({middle[k]:.7g})" for k in range(3))
        place.append(Drive(variables, f"{terms}+m3"))
    scale = tuple(Variable(f"{'abc'[k]}{i}", ob, f"matrix_world[{k}][{i}]") for k in range(3) for i in range(3))
    squares = ",".join("+".join(f"{each}{i}*{each}{i}" for i in range(3)) for each in "abc")
    size = Drive(scale, f"{radius:.7g}*sqrt(max({squares}))")
    switch = Drive((Variable("h", ob, "hide_render"),), f"{KINDS['BALL']}*(1-h)")
    return Source(
        key=(("emitter", ob.as_pointer()), ob.name_full, tuple(round(x, 6) for x in middle), round(radius, 6)),
        name=ob.name,
        kind="BALL",
        entries=(*place, switch, 0.0, 0.0, 0.0, size, 0.0, 0.0, 0.0, 1.0),
        strength=radiance * math.pi * radius**2,
    )


def _ball(ob: bpy.types.Object) -> tuple[Vector, float]:
    """A ball about all vertices of an object's mesh, in its own coordinates."""
    mesh = ob.data
    corners = tuple(round(x, 6) for corner in (ob.bound_box[0], ob.bound_box[6]) for x in corner)
    known = (len(mesh.vertices), corners)
    kept = _balls.get(mesh.as_pointer())
    if kept is not None and kept[0] == known:
        return kept[1], kept[2]
    low, high = (Vector(ob.bound_box[i]) for i in (0, 6))
    middle, radius = 0.5 * (low + high), 0.5 * (high - low).length
    if not ob.modifiers and len(mesh.vertices):
        places = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", places)
        radius = float(np.linalg.norm(places.reshape(-1, 3) - np.array(middle), axis=-1).max())
    _balls[mesh.as_pointer()] = (known, middle, radius)
    return middle, radius
