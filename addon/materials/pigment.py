# SPDX-License-Identifier: GPL-3.0-or-later
"""What the diffraction takes over from the shader underneath: its normal map or bump, and where it is transparent.

The shader is searched as it is wired: through Reroute, Mix Shader, Add Shader and node groups.
"""

from __future__ import annotations

from typing import Any

import bpy

#: Name of nodes that put an alpha together, and the property that tells them from those of the user's.
ALPHA, OURS = "Diffraction Alpha", "diffraction_made"

#: A value known while nodes are made, or the socket that will tell.
Value = Any

_TRANSPARENT = {"ShaderNodeBsdfTransparent", "ShaderNodeHoldout"}


def normal_of(shader: bpy.types.NodeSocket) -> bpy.types.NodeSocket | None:
    """Where the first linked normal of a shader comes from, as a socket of the same tree; None where there is none.

    Parameters
    ----------
    shader
        An input that shaders are linked to.
    """
    for node, stack in _closures(shader, ()):
        normal = node.inputs.get("Normal")
        found = _outside(_source(normal), stack) if normal is not None else None
        if found is not None:
            return found
    return None


def alpha_of(shader: bpy.types.NodeSocket) -> Value:
    """How opaque a shader is: a number, or a socket of the same tree; nodes are added where it is a mixture.

    What a group hides and no socket of it tells counts as opaque.

    Parameters
    ----------
    shader
        An input that shaders are linked to.
    """
    return _alpha(shader, ())


def colour_of(shader: bpy.types.NodeSocket) -> tuple[float, float, float] | None:
    """Colour of the first shader that has one which no link changes; None where none tells it.

    Parameters
    ----------
    shader
        An input that shaders are linked to.
    """
    for node, _ in _closures(shader, ()):
        for name in ("Base Color", "Color"):
            socket = node.inputs.get(name)
            if socket is not None and not socket.is_linked:
                red, green, blue = tuple(socket.default_value)[:3]
                return red, green, blue
    return None


def sees_through(shader: bpy.types.NodeSocket) -> bool:
    """Whether a shader is transparent somewhere, as far as its nodes tell; nothing is added to them.

    Parameters
    ----------
    shader
        An input that shaders are linked to.
    """
    for node, _ in _closures(shader, ()):
        alpha = node.inputs.get("Alpha")
        if node.bl_idname in _TRANSPARENT:
            return True
        if alpha is not None and alpha.type == "VALUE" and (alpha.is_linked or alpha.default_value < 1.0):
            return True
    return False


def remove_alpha(tree: bpy.types.NodeTree) -> None:
    """Remove the nodes that `alpha_of` made."""
    for node in [node for node in tree.nodes if node.get(OURS) == ALPHA]:
        tree.nodes.remove(node)


def _source(socket: Any) -> Any:
    """The output that a socket gets its value from, reroutes left out; None where it is not linked."""
    while socket is not None and socket.is_linked and socket.links:
        link = socket.links[0]
        if link.from_node.bl_idname != "NodeReroute":
            return None if link.is_muted else link.from_socket
        socket = link.from_node.inputs[0]
    return None


def _outside(source: Any, stack: tuple[Any, ...]) -> Any:
    """The same output in the outermost tree: through the inputs of the groups entered; None where it stays inside."""
    while source is not None and stack:
        if source.node.bl_idname != "NodeGroupInput":
            return None
        group, stack = stack[-1], stack[:-1]
        source = _source(_given(group, source))
    return source


def _given(group: Any, source: Any) -> Any:
    """The input of a group's node that an output of its Group Input shows."""
    return next((s for s in group.inputs if s.identifier == source.identifier), None)


def _inside(group: Any, output: Any) -> Any:
    """The input of a group's own output node that an output of the group shows."""
    if group.node_tree is None:
        return None
    found = [n for n in group.node_tree.nodes if n.bl_idname == "NodeGroupOutput" and n.is_active_output]
    return next((s for n in found for s in n.inputs if s.identifier == output.identifier), None)


def _closures(shader: Any, stack: tuple[Any, ...]) -> Any:
    """The closures below an input of shaders, with the groups entered on the way; first inputs first."""
    source = _source(shader)
    if source is None or len(stack) > 16:
        return
    node = source.node
    if node.bl_idname == "ShaderNodeGroup":
        yield from _closures(_inside(node, source), (*stack, node))
    elif node.bl_idname == "NodeGroupInput" and stack:
        yield from _closures(_given(stack[-1], source), stack[:-1])
    elif node.bl_idname in ("ShaderNodeMixShader", "ShaderNodeAddShader"):
        for socket in node.inputs:
            if socket.type == "SHADER":
                yield from _closures(socket, stack)
    else:
        yield node, stack


def _value(socket: Any, stack: tuple[Any, ...]) -> Value:
    """A number, or the socket outside that tells it; None where only the inside of a group knows."""
    source = _source(socket)
    if source is None:
        return float(socket.default_value)
    if not stack:
        return source
    if source.node.bl_idname != "NodeGroupInput":
        return None
    outer = _given(stack[-1], source)
    return None if outer is None else _value(outer, stack[:-1])


def _alpha(shader: Any, stack: tuple[Any, ...]) -> Value:
    source = _source(shader)
    if source is None or len(stack) > 16:
        return 1.0
    node = source.node
    kind = node.bl_idname
    if node.mute:
        return 1.0
    if kind in _TRANSPARENT:
        return 0.0
    if kind == "ShaderNodeGroup":
        return _alpha(_inside(node, source), (*stack, node))
    if kind == "NodeGroupInput" and stack:
        return _alpha(_given(stack[-1], source), stack[:-1])
    if kind in ("ShaderNodeMixShader", "ShaderNodeAddShader"):
        first, second = (_alpha(socket, stack) for socket in node.inputs if socket.type == "SHADER")
        if kind == "ShaderNodeAddShader":
            return _combined(shader, "MAXIMUM", first, second)
        if not isinstance(first, bpy.types.NodeSocket) and first == second:
            return first
        factor = _value(node.inputs[0], stack)
        return 1.0 if factor is None else _mixture(shader, stack, factor, first, second)
    alpha = node.inputs.get("Alpha")
    if alpha is None or alpha.type != "VALUE":
        return 1.0
    value = _value(alpha, stack)
    return 1.0 if value is None else value


def _tree(shader: Any, stack: tuple[Any, ...]) -> bpy.types.NodeTree:
    return stack[0].id_data if stack else shader.id_data


def _math(tree: Any, operation: str, *values: Value) -> bpy.types.NodeSocket:
    node = tree.nodes.new("ShaderNodeMath")
    node.name = node.label = ALPHA
    node[OURS] = ALPHA
    node.operation = operation
    node.hide = True
    for socket, value in zip(node.inputs, values, strict=False):
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = value
    return node.outputs[0]


def _combined(shader: Any, operation: str, first: Value, second: Value) -> Value:
    if not isinstance(first, bpy.types.NodeSocket) and not isinstance(second, bpy.types.NodeSocket):
        return max(first, second)
    some = first if isinstance(first, bpy.types.NodeSocket) else second
    return _math(some.id_data, operation, first, second)


def _mixture(shader: Any, stack: tuple[Any, ...], factor: Value, first: Value, second: Value) -> Value:
    """``first + factor (second - first)``, as far as it is known now a number."""
    values = (factor, first, second)
    if not any(isinstance(value, bpy.types.NodeSocket) for value in values):
        return first + factor * (second - first)
    tree = _tree(shader, stack)
    known = not isinstance(first, bpy.types.NodeSocket) and not isinstance(second, bpy.types.NodeSocket)
    difference = second - first if known else _math(tree, "SUBTRACT", second, first)
    return _math(tree, "MULTIPLY_ADD", factor, difference, first)
