# SPDX-License-Identifier: GPL-3.0-or-later
"""The nodes that let a paint drive a material: one image for Scale, Depth, Rotation and Mask.

The image is looked up with *Closest*: where a texel is smaller than a pixel the samples average light, never angles.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy

from ... import colour_spaces, paths
from .. import material

#: Names of the nodes, and the sockets by the channels of the image.
IMAGE, SPLIT, UV, TURN = "Diffraction Paint", "Diffraction Paint Channels", "Diffraction Paint UV", "Diffraction Turn"
NAMES = (IMAGE, SPLIT, UV, TURN)
CHANNELS = {"Scale": "Red", "Depth": "Green", "Rotation": "Blue"}


def image(shaded: bpy.types.Material) -> bpy.types.Image | None:
    """The paint of a material whose socket Scale follows it; None where there is none."""
    node = material.shader_node(shaded)
    socket = node.inputs.get("Scale") if node is not None else None
    picture = node.id_data.nodes.get(IMAGE) if node is not None else None
    if socket is None or not socket.links or picture is None or socket.links[0].from_node.name != SPLIT:
        return None
    return picture.image


def load(path: Path) -> bpy.types.Image:
    """The image data-block of a paint, read anew where the file was there before."""
    found = None
    for each in bpy.data.images:
        if each.library is None and each.filepath and paths.absolute(each.filepath) == path:
            found = each
            if found.packed_file is not None:
                found.unpack(method="REMOVE")
            found.reload()
            break
    if found is None:
        found = bpy.data.images.load(str(path), check_existing=False)
    found.name = path.stem
    found.filepath = paths.relative(path)
    colour_spaces.set_data(found)
    found.alpha_mode = "CHANNEL_PACKED"
    found.use_half_precision = False
    return found


def wire(shaded: bpy.types.Material, painted: bpy.types.Image, uv_map: str = "") -> None:
    """Let an image drive the sockets; nodes of an earlier paint go, and of other links to these sockets the ends.

    Parameters
    ----------
    shaded
        A material of ours.
    painted
        R scale, G depth, B rotation in radians, A mask.
    uv_map
        Name of the UV map; empty takes the active one.
    """
    node = material.shader_node(shaded)
    tree: Any = node.id_data
    turned = _turn(node)
    remove(shaded)
    nodes, x, y = tree.nodes, node.location.x, node.location.y
    picture = nodes.new("ShaderNodeTexImage")
    picture.name = picture.label = IMAGE
    picture.image, picture.interpolation, picture.extension = painted, "Closest", "REPEAT"
    picture.location = (x - 660.0, y - 420.0)
    split = nodes.new("ShaderNodeSeparateColor")
    split.name = split.label = SPLIT
    split.location = (x - 380.0, y - 420.0)
    add = nodes.new("ShaderNodeMath")
    add.name = add.label = TURN
    add.operation, add.inputs[1].default_value = "ADD", turned
    add.location = (x - 200.0, y - 480.0)
    tree.links.new(picture.outputs["Color"], split.inputs[0])
    for name, channel in CHANNELS.items():
        if name != "Rotation":
            tree.links.new(split.outputs[channel], node.inputs[name])
    tree.links.new(split.outputs["Blue"], add.inputs[0])
    tree.links.new(add.outputs[0], node.inputs["Rotation"])
    tree.links.new(picture.outputs["Alpha"], node.inputs["Mask"])
    if uv_map:
        place = nodes.new("ShaderNodeUVMap")
        place.name = place.label = UV
        place.uv_map = uv_map
        place.location = (x - 860.0, y - 420.0)
        tree.links.new(place.outputs["UV"], picture.inputs["Vector"])


def turn(shaded: bpy.types.Material) -> float:
    """Radians by which the whole paint is turned, or the structure where there is none."""
    return _turn(material.shader_node(shaded))


def _turn(node: Any) -> float:
    """The turn of the whole structure: of an earlier paint, else the socket's own."""
    before = node.id_data.nodes.get(TURN)
    return float(before.inputs[1].default_value if before is not None else node.inputs["Rotation"].default_value)


def remove(shaded: bpy.types.Material) -> bool:
    """Take a paint away again; whether there was one. Sockets go back to what they say unlinked."""
    node = material.shader_node(shaded)
    tree: Any = node.id_data
    old = [each for each in tree.nodes if each.name in NAMES]
    if old:
        node.inputs["Rotation"].default_value = _turn(node)
    for each in old:
        tree.nodes.remove(each)
    return bool(old)
