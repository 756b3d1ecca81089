# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a material diffracts: its socket Mask, as far as nodes tell it by a number or one image."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy

from ...materials import material


@dataclass(frozen=True)
class Mask:
    """``constant + factor texel`` within 0 and 1.

    Parameters
    ----------
    constant, factor
        Numbers.
    image
        What is looked up by the UV map that is rendered; None where the mask is the constant.
    alpha
        Whether the texel is the image's alpha, else its luminance.
    """

    constant: float = 1.0
    factor: float = 0.0
    image: bpy.types.Image | None = None
    alpha: bool = False


#: A mask that is a sum, with the texel that it depends on.
_Linear = tuple[float, float, bpy.types.Image | None, bool]


def of(shaded: bpy.types.Material) -> Mask:
    """The mask of one of our materials; 1 everywhere where its nodes are more than sums and products of one image."""
    node = material.shader_node(shaded)
    socket = node.inputs.get("Mask") if node is not None else None
    if socket is None:
        return Mask()
    found = _value(socket, 16)
    return Mask() if found is None else Mask(*found)


def _value(socket: Any, depth: int) -> _Linear | None:
    links = [link for link in socket.links if not link.is_muted]
    if not links:
        return None if socket.type == "VECTOR" else (_number(socket.default_value), 0.0, None, False)
    if depth == 0:
        return None
    node, output = links[0].from_node, links[0].from_socket
    kind = node.bl_idname
    if node.mute:
        return None
    if kind in {"NodeReroute", "ShaderNodeRGBToBW", "ShaderNodeSeparateColor"}:
        return _value(node.inputs[0], depth - 1)
    if kind in {"ShaderNodeValue", "ShaderNodeRGB"}:
        return _number(output.default_value), 0.0, None, False
    if kind == "ShaderNodeTexImage":
        vector = node.inputs["Vector"]
        plain = not vector.links or vector.links[0].from_node.bl_idname in {"ShaderNodeUVMap", "ShaderNodeTexCoord"}
        return (0.0, 1.0, node.image, output.name == "Alpha") if node.image is not None and plain else None
    if kind == "ShaderNodeInvert":
        given = _value(node.inputs["Color"], depth - 1)
        part = node.inputs["Fac"] if "Fac" in node.inputs else node.inputs[0]
        if given is None or part.links:
            return None
        keep = 1.0 - 2.0 * part.default_value
        return part.default_value + keep * given[0], keep * given[1], given[2], given[3]
    if kind == "ShaderNodeMath":
        return _math(node, depth)
    return None


def _math(node: Any, depth: int) -> _Linear | None:
    values = [_value(socket, depth - 1) for socket in node.inputs[:3]]
    if node.operation not in {"ADD", "SUBTRACT", "MULTIPLY", "MULTIPLY_ADD"}:
        return None
    if any(value is None for value in values[: 3 if node.operation == "MULTIPLY_ADD" else 2]):
        return None
    a, b, c = ((value or (0.0, 0.0, None, False)) for value in values)
    if node.operation == "ADD":
        return _sum(a, b)
    if node.operation == "SUBTRACT":
        return _sum(a, (-b[0], -b[1], b[2], b[3]))
    product = _product(a, b)
    if node.operation == "MULTIPLY" or product is None:
        return product
    return _sum(product, c)


def _sum(a: _Linear, b: _Linear) -> _Linear | None:
    if a[1] and b[1] and (a[2], a[3]) != (b[2], b[3]):
        return None
    image, alpha = (a if a[1] else b)[2:]
    return a[0] + b[0], a[1] + b[1], image, alpha


def _product(a: _Linear, b: _Linear) -> _Linear | None:
    if a[1] and b[1]:
        return None
    if b[1]:
        a, b = b, a
    return a[0] * b[0], a[1] * b[0], a[2], a[3]


def _number(value: Any) -> float:
    """As a link turns it into a number: a colour's luminance."""
    if isinstance(value, (int, float)):
        return float(value)
    red, green, blue = tuple(value)[:3]
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue
