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

#: Linear RGB.
Colour = tuple[float, float, float]

#: Middle and radius of meshes by identity, with what they depended on.
_balls: dict[int, tuple[tuple, Vector, float]] = {}


def sources(scene: bpy.types.Scene) -> Iterator[Source]:
    """Glowing meshes of a scene and its set scenes."""
    for ob, colour in glowing(scene):
        yield _source(ob, sum(colour) / 3.0)


def glowing(scene: bpy.types.Scene) -> Iterator[tuple[bpy.types.Object, Colour]]:
    """Glowing meshes of a scene and its set scenes, with the radiance of the brightest of their materials."""
    radiances = {material: radiance(material) for material in bpy.data.materials}
    radiances = {material: colour for material, colour in radiances.items() if any(colour)}
    if not radiances:
        return
    for each in lamps.with_sets(scene):
        for ob in each.objects:
            if ob.type == "MESH" and lamps.shows(ob):
                found = [radiances[slot.material] for slot in ob.material_slots if slot.material in radiances]
                if found:
                    yield ob, max(found, key=sum)


def strength(material: bpy.types.Material) -> float:
    """Mean of the radiance of what glows in a material; 0 if nothing does."""
    return sum(radiance(material)) / 3.0


def radiance(material: bpy.types.Material) -> Colour:
    """What glows in a material, as far as its nodes tell: emission of the top level; black if none counts."""
    tree = material.node_tree
    dark: Colour = (0.0, 0.0, 0.0)
    if tree is None or getattr(getattr(material, "cycles", None), "emission_sampling", "AUTO") == "NONE":
        return dark
    most = dark
    for node in tree.nodes:
        names = {
            "ShaderNodeEmission": ("Color", "Strength"),
            "ShaderNodeBsdfPrincipled": ("Emission Color", "Emission Strength"),
        }.get(node.bl_idname)
        if names is None or node.mute or not node.outputs[0].links:
            continue
        colour, number = (node.inputs[name] for name in names)
        power = 1.0 if number.links else number.default_value
        red, green, blue = (1.0, 1.0, 1.0) if colour.links else colour.default_value[:3]
        most = max(most, (power * red, power * green, power * blue), key=sum)
    return most


def _source(ob: bpy.types.Object, radiance: float) -> Source:
    middle, radius = ball(ob)
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


def ball(ob: bpy.types.Object) -> tuple[Vector, float]:
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


def shadow_area(ob: bpy.types.Object) -> float:
    """What a glowing mesh looks like from afar, the mean over all sides, m^2: times radiance it is an intensity.

    Of a convex body that is a quarter of its surface (Cauchy), of an open sheet, which glows on both sides, half.
    """
    mesh = ob.data
    number = len(mesh.polygons)
    areas = np.empty(number, np.float32)
    mesh.polygons.foreach_get("area", areas)
    normals = np.empty(3 * number, np.float32)
    mesh.polygons.foreach_get("normal", normals)
    # Areas times normals add up to nothing where a surface closes, whether its seams are joined or not.
    left_over = np.linalg.norm((areas[:, None] * normals.reshape(-1, 3)).sum(0))
    is_closed = bool(left_over < 0.25 * areas.sum())
    scale = abs(ob.matrix_world.to_3x3().determinant()) ** (2.0 / 3.0)
    return float(areas.sum()) * scale * (0.25 if is_closed else 0.5)
