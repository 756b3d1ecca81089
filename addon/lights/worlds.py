# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights of the world: the sun of a Sky Texture, driven by its settings, and bright spots of an environment image."""

from __future__ import annotations

import math
import zlib
from collections.abc import Hashable, Iterator
from typing import Any

import bpy
from mathutils import Euler, Matrix, Vector

from ..versions import EEVEE
from . import animated, hot_spots, slots
from .slots import KINDS
from .source import Drive, Entry, Source, Variable

#: Types of skies that can show a sun's disc.
_WITH_DISC = {"NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING"}

#: Irradiance of a sky's sun for the ranking, in the sky's own units at strength 1: far above what else there is.
_SUN_STRENGTH = 1000.0


def sources(scene: bpy.types.Scene) -> Iterator[Source]:
    """Lights of a scene's world, as far as its nodes tell them: textures with no other vector than a Mapping's."""
    if scene.world is not None:
        yield from of_world(scene.world, scene.render.engine == EEVEE, scene)


def of_world(world: bpy.types.World, by_eevee: bool = False, scene: bpy.types.Scene | None = None) -> Iterator[Source]:
    """Lights of a world; for EEVEE what it takes out of an image's brightest places.

    EEVEE makes one sun of that: listed as it is where the light comes from about there. Where it does not, each bright
    place is listed with the light that it sheds, which materials show by themselves, without shadows. Without the scene
    whose drivers shall follow it a sky's sun is as it is now.
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
                yield _sun(world, node, turn, scene)
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
    return _matrix(before)


def _matrix(mapping: bpy.types.Node) -> Matrix:
    turned = Euler(mapping.inputs["Rotation"].default_value).to_matrix()
    return turned if mapping.vector_type == "TEXTURE" else turned.transposed()


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


def _sun(
    world: bpy.types.World, node: bpy.types.Node, turn: bpy.types.Node | Matrix, scene: bpy.types.Scene | None
) -> Source:
    """The sun of a sky.

    Where its settings are animated the scene has copies of their curves in a property of its own, which drivers follow
    (`animated`). What strips mix is written on each frame, and an edit of what stands still as numbers.
    """
    kind, directions = float(KINDS["SUN"]), ("cos(e)*sin(r)", "cos(e)*cos(r)", "sin(e)")
    settings = {"e": "sun_elevation", "r": "sun_rotation", "d": "sun_disc", "v": "sun_size"}
    now = {name: float(getattr(node, setting)) for name, setting in settings.items()}
    curves = {name: _curve(world, node, setting) for name, setting in settings.items()} if scene is not None else {}
    curves = {name: curve for name, curve in curves.items() if curve is not None}
    is_written = scene is not None and (animated.is_mixed(world) or _is_mixed(world))
    key = ("sky", world.as_pointer(), world.name_full, node.name, node.sky_type)
    frames: dict[str, tuple[Entry, ...]] = {}
    numbers: tuple[Hashable, ...] = ()
    if scene is not None and curves and not is_written:
        told = [animated.signature(curves[name]) if name in curves else now[name] for name in settings]
        name = f"{slots.FRAME}{zlib.crc32(repr((key, told)).encode()):08x}"
        frames[name] = tuple(
            animated.Copied((), "", curves[each], now[each]) if each in curves else now[each] for each in settings
        )
        known = tuple(Variable(each, scene, f'["{name}"][{index}]') for index, each in enumerate(settings))
        place = _turned(world, turn, *directions, known[:2])
        ends: tuple[Entry, Entry] = (Drive(known[2:3], f"{kind}*d"), Drive(known[3:], "v"))
        numbers = (name,)
    else:
        e, r = now["e"], now["r"]
        still = (math.cos(e) * math.sin(r), math.cos(e) * math.cos(r), math.sin(e))
        place, ends = _still(world, turn, *still), (kind * now["d"], now["v"])
        if not is_written:
            numbers = (*still, *ends)
        elif not isinstance(turn, Matrix):  # what is written holds no drivers
            place = _still(world, _matrix(turn), *still)
    return Source(
        key=(*key, is_written, numbers, _signature(turn)),
        name=f"{world.name}: {node.name}",
        kind="SUN",
        entries=(*place, ends[0], 0.0, 0.0, 0.0, ends[1], 0.0, 0.0, 0.0, 0.0),
        frames=frames,
        strength=_SUN_STRENGTH,
        is_written=is_written,
    )


def _curve(world: bpy.types.World, node: bpy.types.Node, setting: str) -> Any:
    """What animates a node's setting, from the tree's animation or the world's."""
    path = f'nodes["{bpy.utils.escape_identifier(node.name)}"].{setting}'
    own = animated.curve_of(world.node_tree, path) if world.node_tree is not None else None
    return own or animated.curve_of(world, f"node_tree.{path}")


def _is_mixed(world: bpy.types.World) -> bool:
    return world.node_tree is not None and animated.is_mixed(world.node_tree)


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
