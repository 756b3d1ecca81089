# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that give a material the tangent frame of its surface."""

from __future__ import annotations

import bpy

TANGENT, BITANGENT = "Diffraction Tangent", "Diffraction Bitangent"


def uv_frame(
    tree: bpy.types.NodeTree, uv_map: str = "", at: tuple[float, float] = (0.0, 0.0)
) -> tuple[bpy.types.NodeSocket, bpy.types.NodeSocket]:
    """Sockets with the directions of growing u and growing v, as normals are transformed.

    A Normal Map node given the tangent-space vector (1, 0, 0) returns the tangent, given (0, 1, 0)
    the bitangent with the sign of mirrored UV maps, which a Tangent node does not tell. It transforms
    both like normals; the shader undoes that.

    Parameters
    ----------
    tree
        Where to add the nodes.
    uv_map
        Name of the UV map; empty takes the active one.
    at
        Location in the node editor.
    """
    sockets = []
    for row, (name, colour) in enumerate(((TANGENT, (1.0, 0.5, 0.5, 1.0)), (BITANGENT, (0.5, 1.0, 0.5, 1.0)))):
        node = tree.nodes.new("ShaderNodeNormalMap")
        node.name = name
        node.label = f"Scan's {'xy'[row]}"
        node.space = "TANGENT"
        node.uv_map = uv_map
        node.inputs["Color"].default_value = colour
        node.location = (at[0], at[1] - 180.0 * row)
        sockets.append(node.outputs["Normal"])
    return sockets[0], sockets[1]
