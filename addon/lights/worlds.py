# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of the world: the sun of a Sky Texture, driven by its settings, and bright spots of an environment image."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
from mathutils import Euler, Matrix, Vector

from ..versions import EEVEE
from . import hot_spots
from .slots import KINDS
from .source import Drive, Entry, Source, Variable

#: Types of skies that can show a sun's disc.
_WITH_DISC = {"NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING"}

#: Irradiance of a sky's sun for the ranking, in the sky's own units at strength 1: far above what else there is.
_SUN_STRENGTH = 1000.0


def sources(scene: bpy.types.Scene) -> Iterator[Source]:
    """Lights of a scene's world, as far as its nodes tell them: textures with no other vector than a Mapping's."""
    if scene.world is not None:
        yield from of_world(scene.world, scene.render.engine == EEVEE)


def of_world(world: bpy.types.World, by_eevee: bool = False) -> Iterator[Source]:
    """Lights of a world; for EEVEE what it takes out of an image's brightest places.

    EEVEE makes one sun of that: listed as it is where the light comes from about there. Where it does not, each bright
    place is listed with the light that it sheds, which materials show by themselves, without shadows.
    """
    tree = world.node_tree
    if tree is None:
        return
    for node in tree.nodes:
        if node.mute or not any(socket.is_linked for socket in node.outputs):
            continue
        if node.bl_idname == "ShaderNodeTexSky" and node.sky_type in _WITH_DISC:
            turn = _turn(node)
            if turn is not None:
                yield _sun(world, node, turn)
        elif node.bl_idname == "ShaderNodeTexEnvironment" and node.image is not None:
            turn = _turn(node)
            if turn is not None and node.projection == "EQUIRECTANGULAR":
                own = list(_own_suns(world, node, turn)) if by_eevee else []
                spots = _eevee_sun(world, node) if by_eevee else hot_spots.of(node.image)
                yield from own or _spots(world, node, turn, spots)


def _turn(node: bpy.types.Node) -> bpy.types.Node | Matrix | None:
    """What turns a texture: a Mapping node about z alone (which a driver can follow), a matrix, or None if unknown."""
    socket = node.inputs.get("Vector")  # skies of Blender 5 have none
    if socket is None or not socket.links:
        return Matrix.Identity(3)
    before = socket.links[0].from_node
    if before.bl_idname == "ShaderNodeTexCoord":
        return Matrix.Identity(3) if socket.links[0].from_socket.name == "Generated" else None
    if before.bl_idname != "ShaderNodeMapping" or before.vector_type == "NORMAL":
        return None
    vector = before.inputs["Vector"]
    if vector.links and vector.links[0].from_socket.name not in {"Generated", "Incoming"}:
        return None
    rotation = before.inputs["Rotation"]
    if rotation.links or any(
        abs(x) > 1e-6 for x in before.inputs["Location"].default_value if before.inputs["Location"].enabled
    ):
        return None
    if all(abs(x) < 1e-6 for x in rotation.default_value[:2]):
        return before
    turned = Euler(rotation.default_value).to_matrix()
    return turned if before.vector_type == "TEXTURE" else turned.transposed()


def _turned(
    world: bpy.types.World, turn: bpy.types.Node | Matrix, x: str, y: str, z: str, known: tuple[Variable, ...]
) -> tuple[Entry, ...]:
    """A direction in the texture's own frame as one of the world: expressions of its components, their variables."""
    if isinstance(turn, Matrix):
        rows = []
        for row in _rows(turn):
            terms = [f"{value:.9g}*({term})" for value, term in zip(row, (x, y, z), strict=True) if abs(value) > 1e-9]
            rows.append("+".join(terms) or "0")
        return tuple(Drive(known, row) for row in rows)
    angle = Variable(
        "q",
        world,
        f'node_tree.nodes["{bpy.utils.escape_identifier(turn.name)}"].inputs[{_index(turn)}].default_value[2]',
    )
    sign = "" if turn.vector_type == "TEXTURE" else "-"  # a point is turned, so what is seen turns the other way
    c, s = f"cos({sign}q)", f"sin({sign}q)"
    return (
        Drive((*known, angle), f"({x})*{c}-({y})*{s}"),
        Drive((*known, angle), f"({x})*{s}+({y})*{c}"),
        Drive(known, z) if known else float(z),
    )


def _path(node: bpy.types.Node) -> str:
    return f'node_tree.nodes["{bpy.utils.escape_identifier(node.name)}"]'


def _rows(matrix: Matrix) -> list[tuple[float, ...]]:
    return [tuple(matrix[i]) for i in range(3)]


def _index(mapping: bpy.types.Node) -> int:
    return list(mapping.inputs).index(mapping.inputs["Rotation"])


def _sun(world: bpy.types.World, node: bpy.types.Node, turn: bpy.types.Node | Matrix) -> Source:
    """The sun of a sky.

    Only where its tree is animated do drivers follow it: of a node's own settings Blender's depsgraph knows nothing and
    says so on the console, for every driver, each time that it is built. Else an edit is written as numbers. What a
    node's sockets hold it does know, so that a driver which has one of them among its variables is evaluated after the
    tree's animation; without it, one frame late as it happens.
    """
    path, kind = _path(node), float(KINDS["SUN"])
    after = Variable("o", world, f"{path}.outputs[0].default_value[0]")
    known = (Variable("e", world, f"{path}.sun_elevation"), Variable("r", world, f"{path}.sun_rotation"), after)
    switch = Drive((Variable("d", world, f"{path}.sun_disc"), after), f"{kind}*d")
    size = Drive((Variable("v", world, f"{path}.sun_size"), after), "v")
    directions = ("cos(e)*sin(r)", "cos(e)*cos(r)", "sin(e)")
    numbers: tuple[float, ...] = ()
    if _is_animated(world):
        ends: tuple[Entry, Entry] = (switch, size)
        place = _turned(world, turn, *directions, known)
    else:
        x, y, z = (Drive(known, each).value() for each in directions)
        ends, place = (switch.value(), size.value()), _still(world, turn, x, y, z)
        numbers = (x, y, z, switch.value(), size.value())
    return Source(
        key=("sky", world.as_pointer(), world.name_full, node.name, node.sky_type, numbers, _signature(turn)),
        name=f"{world.name}: {node.name}",
        kind="SUN",
        entries=(*place, ends[0], 0.0, 0.0, 0.0, ends[1], 0.0, 0.0, 0.0, 0.0),
        strength=_SUN_STRENGTH,
    )


def _is_animated(world: bpy.types.World) -> bool:
    """Whether keys, drivers or strips may move a world's nodes."""
    found = world.node_tree.animation_data
    return found is not None and bool(found.action is not None or found.drivers or found.nla_tracks)


def _still(world: bpy.types.World, turn: bpy.types.Node | Matrix, x: float, y: float, z: float) -> tuple[Entry, ...]:
    """A direction that does not move in the texture's own frame as one of the world."""
    if isinstance(turn, Matrix):
        return tuple(Vector(row).dot(Vector((x, y, z))) for row in _rows(turn))
    return _turned(world, turn, f"{x:.7g}", f"{y:.7g}", f"{z:.7g}", ())


def _eevee_sun(world: bpy.types.World, node: bpy.types.Node) -> list[hot_spots.Spot]:
    """What EEVEE takes out of an image that shines as strongly as the Background node behind it says."""
    colour: Any = node.outputs[0]
    after = [link.to_node for link in colour.links]
    strengths = [each.inputs["Strength"].default_value for each in after if each.bl_idname == "ShaderNodeBackground"]
    strength = strengths[0] if strengths else 1.0
    threshold = getattr(world, "sun_threshold", 0.0)
    return hot_spots.eevee_sun(node.image, threshold / strength) if threshold > 0.0 and strength > 0.0 else []


def _own_suns(world: bpy.types.World, node: bpy.types.Node, turn: bpy.types.Node | Matrix) -> Iterator[Source]:
    """Bright places with their own light, as far as it is known: of an image whose Background alone is the world."""
    colour: Any = node.outputs[0]
    after = [link.to_node for link in colour.links]
    if len(after) != 1 or after[0].bl_idname != "ShaderNodeBackground" or after[0].inputs["Strength"].links:
        return
    shown: Any = after[0].outputs[0]
    if [link.to_node.bl_idname for link in shown.links] != ["ShaderNodeOutputWorld"]:
        return
    strength, threshold = float(after[0].inputs["Strength"].default_value), getattr(world, "sun_threshold", 0.0)
    if strength <= 0.0 or threshold <= 0.0:
        return
    place = list(after[0].inputs).index(after[0].inputs["Strength"])
    follows = (Variable("k", world, f"{_path(after[0])}.inputs[{place}].default_value"),)
    for number, (x, y, z, *light, radius) in enumerate(hot_spots.eevee_own_suns(node.image, threshold / strength)):
        shed = tuple(Drive(follows, f"{each:.6g}*k") for each in light)
        yield Source(
            key=("own", world.as_pointer(), world.name_full, node.name, number, (x, y, z), *light, _signature(turn)),
            name=f"{world.name}: {node.image.name}",
            kind="SUN",
            entries=(
                *_still(world, turn, x, y, z), float(KINDS["SUN"]), *shed, 2.0 * radius, 0.0, 0.0, 0.0, 1.0,
            ),
            strength=strength * sum(light) / 3.0,
        )  # fmt: skip


def _spots(
    world: bpy.types.World, node: bpy.types.Node, turn: bpy.types.Node | Matrix, spots: list[hot_spots.Spot]
) -> Iterator[Source]:
    for number, (x, y, z, radius, strength) in enumerate(spots):
        yield Source(
            key=("image", world.as_pointer(), world.name_full, node.name, number, (x, y, z), radius, _signature(turn)),
            name=f"{world.name}: {node.image.name}",
            kind="SUN",
            entries=(
                *_still(world, turn, x, y, z), float(KINDS["SUN"]), 0.0, 0.0, 0.0, 2.0 * radius, 0.0, 0.0, 0.0, 1.0,
            ),
            strength=strength,
        )  # fmt: skip


def _signature(turn: bpy.types.Node | Matrix) -> tuple:
    if isinstance(turn, Matrix):
        return tuple(x for row in _rows(turn) for x in row)
    return turn.name, turn.vector_type
