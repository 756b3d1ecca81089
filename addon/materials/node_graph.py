# SPDX-License-Identifier: GPL-3.0-or-later
"""Formulas as shader nodes: small functions that add a node and return its socket."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import bpy

from . import batch

Socket = bpy.types.NodeSocket

#: A socket, or a constant that goes into the socket it is given to.
Value = Socket | float | tuple[float, float, float]


class Graph:
    """Adds nodes to a tree, left to right.

    Parameters
    ----------
    tree
        A shader node tree.
    """

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree
        batch.changes(tree)
        self._place = 0
        self._unit: Socket | None = None

    def add(self, kind: str, **properties: object) -> bpy.types.Node:
        """A node of a type, its properties set, collapsed and out of the way of the others."""
        node = self.tree.nodes.new(kind)
        # EEVEE adds nodes "Math" of its own and looks, for each, for a number that no other "Math" has: among thousands
        # of ours that takes minutes.
        node.name = f"{kind.removeprefix('ShaderNode')} {self._place}"
        for name, value in properties.items():
            setattr(node, name, value)
        node.hide = True
        batch.place(node, (180.0 * (self._place // 12), -60.0 * (self._place % 12)))
        self._place += 1
        return batch.of_group(node) if kind in batch.GROUPS else node

    def put(self, socket: Socket, value: Value) -> None:
        """Link a socket to a value, or set it."""
        batch.put(socket, value)

    def math(self, operation: str, *values: Value) -> Socket:
        """A Math node."""
        node = self.add("ShaderNodeMath", operation=operation)
        for socket, value in zip(node.inputs, values, strict=False):
            self.put(socket, float(value) if isinstance(value, (int, float)) else value)
        return node.outputs[0]

    def sum(self, a: Value, b: Value) -> Socket:
        """a + b."""
        return self.math("ADD", a, b)

    def difference(self, a: Value, b: Value) -> Socket:
        """a - b."""
        return self.math("SUBTRACT", a, b)

    def product(self, a: Value, b: Value, *others: Value) -> Socket:
        """a b c ..."""
        made = self.math("MULTIPLY", a, b)
        for other in others:
            made = self.math("MULTIPLY", made, other)
        return made

    def quotient(self, a: Value, b: Value) -> Socket:
        """a / b, 0 where b is 0."""
        return self.math("DIVIDE", a, b)

    def fused(self, a: Value, b: Value, c: Value) -> Socket:
        """a b + c."""
        return self.math("MULTIPLY_ADD", a, b, c)

    def clamp(self, a: Value, low: Value, high: Value) -> Socket:
        """a within [low, high]."""
        node = self.add("ShaderNodeClamp")
        for socket, value in zip(node.inputs, (a, low, high), strict=True):
            self.put(socket, value)
        return node.outputs[0]

    def vector(self, operation: str, *values: Value) -> Socket:
        """A Vector Math node that gives a vector."""
        return self._vector_node(operation, values).outputs["Vector"]

    def scalar(self, operation: str, *values: Value) -> Socket:
        """A Vector Math node that gives a number (DOT_PRODUCT, LENGTH)."""
        return self._vector_node(operation, values).outputs["Value"]

    def scaled(self, a: Value, by: Value) -> Socket:
        """A vector times a number."""
        node = self.add("ShaderNodeVectorMath", operation="SCALE")
        self.put(node.inputs[0], a)
        self.put(node.inputs["Scale"], by)
        return node.outputs["Vector"]

    def _vector_node(self, operation: str, values: tuple[Value, ...]) -> bpy.types.Node:
        node = self.add("ShaderNodeVectorMath", operation=operation)
        for socket, value in zip(node.inputs, values, strict=False):
            self.put(socket, value)
        return node

    def split(self, vector: Value) -> tuple[Socket, Socket, Socket]:
        """Components of a vector."""
        node = self.add("ShaderNodeSeparateXYZ")
        self.put(node.inputs[0], vector)
        x, y, z = node.outputs
        return x, y, z

    def join(self, x: Value, y: Value, z: Value) -> Socket:
        """A vector of components."""
        node = self.add("ShaderNodeCombineXYZ")
        for socket, value in zip(node.inputs, (x, y, z), strict=True):
            self.put(socket, value)
        return node.outputs[0]

    def mix(self, factor: Value, a: Value, b: Value) -> Socket:
        """Vectors a (1 - factor) + b factor."""
        node = self.add("ShaderNodeMix", data_type="VECTOR", clamp_factor=False)
        for name, value in (("Factor_Float", factor), ("A_Vector", a), ("B_Vector", b)):
            self.put(next(s for s in node.inputs if s.identifier == name), value)
        return next(s for s in node.outputs if s.identifier == "Result_Vector")

    def choose(self, flag: Value, a: Value, b: Value) -> Socket:
        """Number a where the flag is 0, b where it is 1.

        Cycles knows the flag of a lamp when it compiles, and drops products with a constant 0 and all that leads to
        them; of a Multiply Add it drops nothing.
        """
        return self.sum(self.product(flag, b), self.product(self.difference(1.0, flag), a))

    def for_cycles(self, a: Value) -> Socket:
        """100 a in Cycles, 0 in EEVEE, which then leaves out all that leads to a.

        EEVEE has no IES textures; Cycles takes the strength times 100 where the texture names no file.
        """
        node = self.add("ShaderNodeTexIES", label="Not in EEVEE")
        self.put(node.inputs["Vector"], self.unit)
        self.put(node.inputs["Strength"], a)
        return node.outputs[0]

    def in_eevee(self) -> Socket:
        """1 in EEVEE, 0 in Cycles, which then leaves out what it is multiplied into.

        EEVEE alone turns shaders into colours; Cycles does not know that node and takes the next one's own value. That
        must be a number's node: a Mix Shader right behind would make EEVEE count the shader twice, as part of its own
        branch and of the material's, and the factor would be 2.
        """
        white, engine = self.add("ShaderNodeEmission"), self.add("ShaderNodeShaderToRGB", label="1 in EEVEE")
        self.put(engine.inputs[0], white.outputs[0])
        flag = self.add("ShaderNodeMath", operation="GREATER_THAN", label="EEVEE")
        flag.inputs[0].default_value, flag.inputs[1].default_value = 0.0, 0.5
        self.put(flag.inputs[0], engine.outputs[0])
        return flag.outputs[0]

    @property
    def unit(self) -> Socket:
        """A vector of length 1, for sockets that mean something else where nothing is linked.

        No constant: Blender, which unrolls groups before it hands them to Cycles, adds a node for each socket without a
        field that a constant is linked to, and compares its name with those of all others.
        """
        if self._unit is None:
            self._unit = self.add("ShaderNodeNewGeometry").outputs["Incoming"]
        return self._unit

    def group(self, tree: bpy.types.NodeTree, **values: Value) -> bpy.types.Node:
        """An instance of a node group."""
        node = self.add("ShaderNodeGroup", node_tree=tree)
        for name, value in values.items():
            self.put(node.inputs[name], value)
        return node


def new_group(name: str) -> bpy.types.NodeTree:
    """An empty shader node group of a name; one that exists is emptied."""
    tree = bpy.data.node_groups.get(name)
    if tree is None or tree.library is not None or tree.bl_idname != "ShaderNodeTree":
        tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
    tree.nodes.clear()
    return tree


def shared_group(
    name: str,
    inputs: Mapping[str, tuple[str, object]],
    outputs: dict[str, str],
    fill: Callable[[Graph, Any, Any], None],
) -> bpy.types.NodeTree:
    """A group that hangs on no table, as this file has it, or made: every node that is added takes its time.

    Parameters
    ----------
    name, inputs, outputs
        Of the group, see `interface`; one of that name with other sockets is made anew.
    fill
        Adds its nodes to a graph, from the sockets given to those wanted.
    """
    tree = bpy.data.node_groups.get((name, None))
    if tree is None or set(tree.interface.items_tree.keys()) != {*inputs, *outputs} or not tree.nodes:
        tree = new_group(name)
        interface(tree, inputs, outputs)
        graph = Graph(tree)
        given = graph.add("NodeGroupInput").outputs if inputs else None
        fill(graph, given, graph.add("NodeGroupOutput").inputs)
    return tree


def interface(tree: bpy.types.NodeTree, inputs: Mapping[str, tuple[str, object]], outputs: dict[str, str]) -> None:
    """Make a group's sockets exactly these; those that stay keep their values where the group is used.

    Parameters
    ----------
    inputs
        Name: (socket type, default or None).
    outputs
        Name: socket type.
    """
    wanted = {("INPUT", name): kind for name, (kind, _) in inputs.items()}
    wanted |= {("OUTPUT", name): kind for name, kind in outputs.items()}
    for item in list(tree.interface.items_tree):
        if wanted.get((item.in_out, item.name)) != item.socket_type:
            tree.interface.remove(item)
    there = {(item.in_out, item.name) for item in tree.interface.items_tree}
    for (in_out, name), kind in wanted.items():
        if (in_out, name) in there:
            continue
        item = tree.interface.new_socket(name, in_out=in_out, socket_type=kind)
        default = inputs[name][1] if in_out == "INPUT" else None
        if default is not None:
            item.default_value = default
