# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that read the light list of the scene that is being rendered (`lights.slots`), for every implementation.

`lamp` gives a group node of one slot with these outputs, all of the world's space:

=======  ======  ==================================================================================
Place    vector  sun: direction to it, of any length; others: position
Kind     float   `lights.slots.KINDS`, 0 where the slot is empty or its lamp switched off
U, V     vector  area: half its extents along its own x and y; else 0, but U of a sun that brings its light along for
                 EEVEE: the irradiance
Size     float   sun: its angle (full); ball: its radius; area: its spread (full angle, pi: all round)
Uneven   float   1 where light within the shape is uneven (a texture, a mesh in its bounding ball), else 0
=======  ======  ==================================================================================

`count` gives the number of slots in use, `matrix` the rows of the matrix from XYZ to the working space. A scene without
a list reads as zeros.
"""

from __future__ import annotations

from typing import Any

import bpy

from ....precompute.light.colour import xyz_to_rgb_matrix
from ...colour_spaces import working_space
from ...lights import slots
from ..node_graph import Graph, Socket, shared_group

#: Outputs of a slot's group: name, type.
OUTPUTS = {
    "Place": "NodeSocketVector",
    "Kind": "NodeSocketFloat",
    "U": "NodeSocketVector",
    "Size": "NodeSocketFloat",
    "V": "NodeSocketVector",
    "Uneven": "NodeSocketFloat",
}

#: Names of the nodes of a matrix of a group's own.
OWN_MATRIX = ("To Red", "To Green", "To Blue")


def _attribute(graph: Graph, name: str) -> bpy.types.Node:
    return graph.add("ShaderNodeAttribute", attribute_type="VIEW_LAYER", attribute_name=name, label=name)


def lamp(graph: Graph, slot: int) -> bpy.types.Node:
    """A node with the outputs above, of a slot counted from 1."""
    name = f"Diffraction Lamp {slot:02d}"

    def fill(inner: Graph, _: Any, wanted: Any) -> None:
        pairs = (("Place", "Kind"), ("U", "Size"), ("V", "Uneven"))
        for each, (vector, number) in zip(slots.names(slot), pairs, strict=True):
            read = _attribute(inner, each).outputs
            inner.put(wanted[vector], read["Vector"])
            inner.put(wanted[number], read["Alpha"])

    return graph.add("ShaderNodeGroup", node_tree=shared_group(name, {}, OUTPUTS, fill), label=name)


def count(graph: Graph) -> Socket:
    """Number of slots in use."""
    return _attribute(graph, slots.COUNT).outputs["Fac"]


def matrix(graph: Graph, illuminant: Any = None) -> tuple[Socket, ...]:
    """Rows to red, green and blue: the scene's, or of a light that the scene's do not fit, as constants.

    Parameters
    ----------
    illuminant
        A sidecar's entry; None takes the scene's matrix.
    """
    if illuminant is None:
        return tuple(_attribute(graph, name).outputs["Vector"] for name in slots.MATRIX)
    rows = []
    for name, values in zip(OWN_MATRIX, xyz_to_rgb_matrix(working_space(), illuminant), strict=True):
        node = graph.add("ShaderNodeCombineXYZ", label=name)
        node.name = name  # `group.follow_working_space` finds it by that
        for socket, value in zip(node.inputs, values, strict=True):
            socket.default_value = float(value)
        rows.append(node.outputs[0])
    return tuple(rows)
