# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as a point of the surface sees them, and how close they stand to one another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ...lights import slots
from ..node import lamp_nodes
from ..node_graph import Graph, Socket, interface, new_group

_FLOAT, _VECTOR = "NodeSocketFloat", "NodeSocketVector"

#: Spread (full angle) from which an area lamp shines all round.
ALL_ROUND = 3.14

#: Where a lamp that is off begins, as seen from any other: so far away that none gives way to it.
_NOWHERE = -10.0

_SLOTS = range(1, slots.SLOTS + 1)


@dataclass(frozen=True)
class Seen:
    """A lamp as a point of the surface sees it.

    Parameters
    ----------
    axis
        Direction to its middle, unit.
    distance
        To its middle.
    radius
        Of a cone about the axis that holds it, radians.
    held
        Half-angle of the least lobe that holds it.
    offset
        To its middle; of a sun the direction as the list has it.
    u, v
        Half extents of an area lamp, else 0.
    is_on, is_sun, is_area, is_rectangle
        Numbers 0 or 1. A glowing mesh counts as off from within its ball: there is nothing to aim at, and what shines
        is left to the environment.
    """

    axis: Socket
    distance: Socket
    radius: Socket
    held: Socket
    offset: Socket
    u: Socket
    v: Socket
    is_on: Socket
    is_sun: Socket
    is_area: Socket
    is_rectangle: Socket


def seen(graph: Graph, position: Socket, lamp: Any) -> Seen:
    """A lamp of the list, whose outputs are those of `lamp_nodes.lamp`."""
    kind, size = lamp["Kind"], lamp["Size"]
    is_sun, is_area = graph.math("LESS_THAN", kind, 1.5), graph.math("GREATER_THAN", kind, 2.5)
    # Products and sums that Cycles can drop, see `Graph.choose`: of a sun nothing here depends on the position.
    from_here = graph.scaled(position, graph.difference(1.0, is_sun))
    offset = graph.vector("SUBTRACT", lamp["Place"], from_here)
    u, v = lamp["U"], lamp["V"]
    axis, distance = graph.vector("NORMALIZE", offset), graph.scalar("LENGTH", offset)
    sine = graph.quotient(size, distance)
    of_ball = graph.math("ARCSINE", graph.math("MINIMUM", sine, 1.0))
    radius = graph.choose(is_area, of_ball, _of_area(graph, axis, distance, u, v))
    radius = graph.choose(is_sun, radius, graph.product(size, 0.5))
    # Of an uneven ball alone this depends on the place.
    is_within = graph.product(lamp["Uneven"], graph.difference(1.0, graph.sum(is_sun, is_area)))
    is_within = graph.product(is_within, graph.math("GREATER_THAN", sine, 0.9))
    is_on = graph.product(graph.math("GREATER_THAN", kind, 0.5), graph.difference(1.0, is_within))
    return Seen(
        axis=axis, distance=distance, radius=radius, held=graph.fused(radius, 1.02, 0.002), offset=offset, u=u, v=v,
        is_on=is_on, is_sun=is_sun, is_area=is_area,
        is_rectangle=graph.math("COMPARE", kind, float(slots.KINDS["RECTANGLE"]), 0.25),
    )  # fmt: skip


def _of_area(graph: Graph, axis: Socket, distance: Socket, u: Socket, v: Socket) -> Socket:
    """Angle between the middle of an area lamp and its farthest corner, or a little more.

    A corner m nearer along the axis stands sqrt(c^2 - m^2) off it, with c half the diagonal. Corners lie as far as
    |u axis| + |v axis| nearer; of all points of a ball of radius c those c^2 / distance nearer look farthest off.
    """
    square = graph.sum(graph.scalar("DOT_PRODUCT", u, u), graph.scalar("DOT_PRODUCT", v, v))
    leans = [graph.math("ABSOLUTE", graph.scalar("DOT_PRODUCT", each, axis)) for each in (u, v)]
    nearer = graph.math("MINIMUM", graph.sum(*leans), graph.quotient(square, distance))
    off = graph.math("SQRT", graph.difference(square, graph.product(nearer, nearer)))
    return graph.math("ARCTAN2", off, graph.difference(distance, nearer))


def place() -> bpy.types.NodeTree:
    """Group of a slot: the direction to its lamp, and the radius of what others have to keep clear of."""
    tree = new_group("Diffraction lamp's place")
    inputs = {name: (kind, None) for name, kind in (lamp_nodes.OUTPUTS | {"Position": _VECTOR}).items()}
    interface(tree, inputs, {"Axis": _VECTOR, "Edge": _FLOAT})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    lamp = seen(graph, given["Position"], given)
    out = graph.add("NodeGroupOutput")
    graph.put(out.inputs["Axis"], lamp.axis)
    graph.put(out.inputs["Edge"], graph.choose(lamp.is_on, _NOWHERE, graph.product(lamp.radius, 1.02)))
    return tree


def gaps() -> bpy.types.NodeTree:
    """Group (direction and radius of every lamp) -> for each the angle from its middle to the nearest other lamp."""
    name = "Diffraction gaps between lamps"
    graph, given, out = _new(name, _each("Axis") | _each("Edge"), _each("Gap"))
    angle, nearest = _angles(), _nearest()
    apart: dict[tuple[int, int], Socket] = {}
    for i in _SLOTS:
        one = graph.group(angle, Axis=given[f"Axis {i}"], **_numbered("Axis", given, i)).outputs
        for place, j in enumerate(_others(i), 1):
            apart.setdefault((min(i, j), max(i, j)), one[f"Angle {place}"])
    for i in _SLOTS:
        to = {f"Angle {place}": apart[min(i, j), max(i, j)] for place, j in enumerate(_others(i), 1)}
        one = graph.group(nearest, **to, **_numbered("Edge", given, i)).outputs
        graph.put(out.inputs[f"Gap {i}"], one["Gap"])
    return graph.tree


def hits() -> bpy.types.NodeTree:
    """Group (where each lobe is aimed, each lamp's direction, cosine of its whole lobe) -> lobes that hold each aim.

    A lamp that has no whole lobe gives a cosine of 2.
    """
    name = "Diffraction lobes that meet"
    graph, given, out = _new(name, _each("Aim") | _each("Axis") | _each("Cosine"), _each("Hits"))
    group = _hits_of_one()
    for i in _SLOTS:
        those = _numbered("Axis", given, i) | _numbered("Cosine", given, i)
        graph.put(out.inputs[f"Hits {i}"], graph.group(group, Aim=given[f"Aim {i}"], **those).outputs["Hits"])
    return graph.tree


# Blender takes the longer for each node the more there are in the tree: what repeats is a small group.


def _angles() -> bpy.types.NodeTree:
    graph, given, out = _new("Diffraction angles to others", {"Axis": _VECTOR} | _each("Axis", 1), _each("Angle", 1))
    for place in _SLOTS[:-1]:
        cosine = graph.scalar("DOT_PRODUCT", given["Axis"], given[f"Axis {place}"])
        graph.put(out.inputs[f"Angle {place}"], graph.math("ARCCOSINE", cosine))
    return graph.tree


def _nearest() -> bpy.types.NodeTree:
    graph, given, out = _new("Diffraction nearest other", _each("Angle", 1) | _each("Edge", 1), {"Gap": _FLOAT})
    gaps = [graph.difference(given[f"Angle {place}"], given[f"Edge {place}"]) for place in _SLOTS[:-1]]
    gap = gaps[0]
    for each in gaps[1:]:
        gap = graph.math("MINIMUM", gap, each)
    graph.put(out.inputs["Gap"], gap)
    return graph.tree


def _hits_of_one() -> bpy.types.NodeTree:
    sockets = {"Aim": _VECTOR} | _each("Axis", 1) | _each("Cosine", 1)
    graph, given, out = _new("Diffraction lobes that hold one", sockets, {"Hits": _FLOAT})
    total: Socket | float = 0.0
    for place in _SLOTS[:-1]:
        cosine = graph.scalar("DOT_PRODUCT", given["Aim"], given[f"Axis {place}"])
        total = graph.sum(total, graph.math("GREATER_THAN", cosine, given[f"Cosine {place}"]))
    graph.put(out.inputs["Hits"], total)
    return graph.tree


def _others(slot: int) -> list[int]:
    """All slots but one, the last first: those that are empty are constants to Cycles, and fold."""
    return [other for other in reversed(_SLOTS) if other != slot]


def _each(name: str, less: int = 0) -> dict[str, str]:
    kind = _VECTOR if name in {"Axis", "Aim"} else _FLOAT
    return {f"{name} {slot}": kind for slot in range(1, slots.SLOTS + 1 - less)}


def _numbered(name: str, given: Any, slot: int) -> dict[str, Socket]:
    """Sockets of the other slots, counted in the order of `_others`."""
    return {f"{name} {place}": given[f"{name} {other}"] for place, other in enumerate(_others(slot), 1)}


def _new(name: str, inputs: dict[str, str], outputs: dict[str, str]) -> tuple[Graph, Any, bpy.types.Node]:
    tree = new_group(name)
    interface(tree, {each: (kind, None) for each, kind in inputs.items()}, outputs)
    graph = Graph(tree)
    return graph, graph.add("NodeGroupInput").outputs, graph.add("NodeGroupOutput")
