# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that give a material the tangent frame of its surface."""

from __future__ import annotations

import math

import bpy

TANGENT, BITANGENT = "Diffraction Tangent", "Diffraction Bitangent"
HANDEDNESS = "Diffraction Handedness"
ATTRIBUTE, ANGLE_IMAGE = "Diffraction Attribute", "Diffraction Angle Image"
ANGLE = "Diffraction Angle"
PLACE, FROM_AXIS, AROUND = "Diffraction Place", "Diffraction From Axis", "Diffraction Around"

#: Nodes that a material's orientation is made of.
NAMES = {TANGENT, BITANGENT, HANDEDNESS, ATTRIBUTE, ANGLE_IMAGE, ANGLE, PLACE, FROM_AXIS, AROUND}

#: Rotation (radians) that makes the tangent of `radial_frame` point outwards.
RADIAL_TURN = -0.5 * math.pi


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


def uv_directions(
    tree: bpy.types.NodeTree, uv_map: str = "", at: tuple[float, float] = (0.0, 0.0)
) -> tuple[bpy.types.NodeSocket, bpy.types.NodeSocket]:
    """Sockets with the direction of growing u and the sign of mirrored UV maps (1 or -1), for OSL.

    Half the cost of `uv_frame`, and the tangent comes as a direction. The sign is an attribute that
    only Cycles knows.

    Parameters
    ----------
    tree
        Where to add the nodes.
    uv_map
        Name of the UV map; empty takes the active one.
    at
        Location in the node editor.
    """
    node, sign = tree.nodes.new("ShaderNodeTangent"), tree.nodes.new("ShaderNodeAttribute")
    node.name, sign.name = TANGENT, HANDEDNESS
    node.label, sign.label = "Scan's x", "Mirrored UV"
    node.direction_type = "UV_MAP"
    node.uv_map = uv_map
    sign.attribute_name = f"{uv_map}.tangent_sign" if uv_map else "tangent_sign"
    node.location, sign.location = at, (at[0], at[1] - 180.0)
    return node.outputs["Tangent"], sign.outputs["Fac"]


def attribute_frame(
    tree: bpy.types.NodeTree, name: str, at: tuple[float, float] = (0.0, 0.0)
) -> tuple[bpy.types.NodeSocket, None]:
    """Tangent from a vector attribute of the mesh, in object space; its part along the normal does not count."""
    read, turn = tree.nodes.new("ShaderNodeAttribute"), tree.nodes.new("ShaderNodeVectorTransform")
    read.name, turn.name = ATTRIBUTE, TANGENT
    read.attribute_name = name
    turn.vector_type, turn.convert_from, turn.convert_to = "VECTOR", "OBJECT", "WORLD"
    read.location, turn.location = (at[0] - 200.0, at[1]), at
    tree.links.new(read.outputs["Vector"], turn.inputs["Vector"])
    return turn.outputs["Vector"], None


def radial_frame(tree: bpy.types.NodeTree, at: tuple[float, float] = (0.0, 0.0)) -> tuple[bpy.types.NodeSocket, None]:
    """Tangent around the object's z axis through the middle of its bounding box: counter-clockwise.

    Turned back by a right angle (`RADIAL_TURN`) the scan's x points away from the axis. The direction is that of a
    Tangent node, which Cycles however turns like a normal where Open Shading Language is off.
    """
    place, centred = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
    around, turn = tree.nodes.new("ShaderNodeVectorMath"), tree.nodes.new("ShaderNodeVectorTransform")
    place.name, centred.name, around.name, turn.name = PLACE, FROM_AXIS, AROUND, TANGENT
    centred.label, around.label, turn.label = "From the middle", "Around z", "Scan's -y"
    centred.operation, centred.inputs[1].default_value = "SUBTRACT", (0.5, 0.5, 0.5)
    around.operation, around.inputs[0].default_value = "CROSS_PRODUCT", (0.0, 0.0, 1.0)
    turn.vector_type, turn.convert_from, turn.convert_to = "VECTOR", "OBJECT", "WORLD"
    for column, node in enumerate((turn, around, centred, place)):
        node.location = (at[0] - 180.0 * column, at[1])
    tree.links.new(place.outputs["Generated"], centred.inputs[0])
    tree.links.new(centred.outputs["Vector"], around.inputs[1])
    tree.links.new(around.outputs["Vector"], turn.inputs["Vector"])
    return turn.outputs["Vector"], None


def angle_image(
    tree: bpy.types.NodeTree, image: bpy.types.Image, turn: float, at: tuple[float, float] = (0.0, 0.0)
) -> bpy.types.NodeSocket:
    """Rotation from an image: black to white is one whole turn, counted from ``turn`` (radians)."""
    texture, scale = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeMath")
    texture.name, scale.name = ANGLE_IMAGE, ANGLE
    texture.image = image
    texture.interpolation = "Closest"  # between white and black lies a whole turn, not half of one
    scale.operation = "MULTIPLY_ADD"
    scale.inputs[1].default_value, scale.inputs[2].default_value = 2.0 * math.pi, turn
    texture.location, scale.location = (at[0] - 300.0, at[1]), at
    tree.links.new(texture.outputs["Color"], scale.inputs[0])
    return scale.outputs["Value"]
