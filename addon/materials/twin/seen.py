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
    diagonal = graph.math("SQRT", graph.sum(graph.scalar("DOT_PRODUCT", u, u), graph.scalar("DOT_PRODUCT", v, v)))
    extent = graph.choose(is_area, size, diagonal)
    distance = graph.scalar("LENGTH", offset)
    sine = graph.quotient(extent, distance)
    of_ball = graph.math("ARCSINE", graph.math("MINIMUM", sine, 1.0))
    radius = graph.choose(is_sun, of_ball, graph.product(size, 0.5))
    # Of an uneven ball alone this depends on the place.
    is_within = graph.product(lamp["Uneven"], graph.difference(1.0, graph.sum(is_sun, is_area)))
    is_within = graph.product(is_within, graph.math("GREATER_THAN", sine, 0.9))
    is_on = graph.product(graph.math("GREATER_THAN", kind, 0.5), graph.difference(1.0, is_within))
    return Seen(
        axis=graph.vector("NORMALIZE", offset), distance=distance, radius=radius,
        held=graph.fused(radius, 1.02, 0.002), offset=offset, u=u, v=v, is_on=is_on, is_sun=is_sun, is_area=is_area,
        is_rectangle=graph.math("COMPARE", kind, float(slots.KINDS["RECTANGLE"]), 0.25),
    )  # fmt: skip


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


def _each(name: str) -> dict[str, str]:
    kind = _VECTOR if name in {"Axis", "Aim"} else _FLOAT
    return {f"{name} {slot}": kind for slot in range(1, slots.SLOTS + 1)}


def gaps() -> bpy.types.NodeTree:
    """Group (direction and radius of every lamp) -> for each the angle from its middle to the nearest other lamp.

    Chains run from the last slot to the first: those that are empty are constants to Cycles.
    """
    tree = new_group("Diffraction gaps between lamps")
    interface(tree, {name: (kind, None) for name, kind in (_each("Axis") | _each("Edge")).items()}, _each("Gap"))
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    nearest: dict[int, Socket] = {}
    pairs = [(i, j) for j in range(slots.SLOTS, 0, -1) for i in range(j - 1, 0, -1)]
    apart = {
        (i, j): graph.math("ARCCOSINE", graph.scalar("DOT_PRODUCT", given[f"Axis {i}"], given[f"Axis {j}"]))
        for i, j in pairs
    }
    for i in range(1, slots.SLOTS + 1):
        for j in range(slots.SLOTS, 0, -1):
            if i != j:
                gap = graph.difference(apart[min(i, j), max(i, j)], given[f"Edge {j}"])
                nearest[i] = gap if i not in nearest else graph.math("MINIMUM", nearest[i], gap)
    out = graph.add("NodeGroupOutput")
    for i, gap in nearest.items():
        graph.put(out.inputs[f"Gap {i}"], gap)
    return tree


def hits() -> bpy.types.NodeTree:
    """Group (where each lobe is aimed, each lamp's direction, cosine of its whole lobe) -> lobes that hold each aim.

    A lamp that has no whole lobe gives a cosine of 2.
    """
    tree = new_group("Diffraction lobes that meet")
    sockets = _each("Aim") | _each("Axis") | _each("Cosine")
    interface(tree, {name: (kind, None) for name, kind in sockets.items()}, _each("Hits"))
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    out = graph.add("NodeGroupOutput")
    for i in range(1, slots.SLOTS + 1):
        total: Socket | None = None
        for j in range(slots.SLOTS, 0, -1):
            if i != j:
                cosine = graph.scalar("DOT_PRODUCT", given[f"Aim {i}"], given[f"Axis {j}"])
                within = graph.math("GREATER_THAN", cosine, given[f"Cosine {j}"])
                total = within if total is None else graph.sum(total, within)
        assert total is not None
        graph.put(out.inputs[f"Hits {i}"], total)
    return tree
