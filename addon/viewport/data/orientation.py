# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a material's tangent comes from, read from its nodes."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ...materials import material
from ...materials.node import frame

#: Modes: the tangent of a UV map, a vector attribute of the mesh, round an axis of the object, the object's x.
MODES = ("UV", "ATTRIBUTE", "RADIAL", "OBJECT")


@dataclass(frozen=True)
class Orientation:
    """How the scan lies on the surface.

    Parameters
    ----------
    mode
        One of `MODES`.
    name
        Of the UV map (empty: the active one) or the attribute, or the axis ``X``, ``Y``, ``Z``.
    """

    mode: str = "UV"
    name: str = ""


def of(shaded: bpy.types.Material) -> Orientation:
    """The orientation of one of our materials."""
    node = material.shader_node(shaded)
    socket = node.inputs.get("Tangent") if node is not None else None
    if socket is None or not socket.links:  # then the node takes the active UV map
        return Orientation()
    return _follow(socket)


def angle_image(shaded: bpy.types.Material) -> tuple[bpy.types.Image, float] | None:
    """The image that turns the scan and the angle (radians) of its black; None where there is none."""
    node = material.shader_node(shaded)
    socket = node.inputs.get("Rotation") if node is not None else None
    picture = node.id_data.nodes.get(frame.ANGLE_IMAGE) if node is not None else None
    if socket is None or not socket.links or picture is None or picture.image is None:
        return None
    scale = socket.links[0].from_node
    return picture.image, float(scale.inputs[2].default_value) if len(scale.inputs) > 2 else 0.0


def _follow(socket: bpy.types.NodeSocket, depth: int = 8) -> Orientation:
    """The first node upstream that says where directions come from."""
    if not socket.links or depth == 0:
        return Orientation()
    node = socket.links[0].from_node
    if node.bl_idname == "ShaderNodeNormalMap":
        return Orientation("UV", node.uv_map)
    if node.bl_idname == "ShaderNodeTangent":
        if node.direction_type == "RADIAL":
            return Orientation("RADIAL", node.axis)
        return Orientation("UV", node.uv_map)
    if node.bl_idname == "ShaderNodeAttribute":
        return Orientation("ATTRIBUTE", node.attribute_name)
    if node.bl_idname == "ShaderNodeUVMap":
        return Orientation("UV", node.uv_map)
    if node.bl_idname == "ShaderNodeVectorMath" and node.operation == "CROSS_PRODUCT" and not node.inputs[0].links:
        axis = max("XYZ", key=lambda name: node.inputs[0].default_value["XYZ".index(name)])  # `frame.radial_frame`
        return Orientation("RADIAL", axis)
    for each in node.inputs:
        if each.links:
            return _follow(each, depth - 1)
    return Orientation()
