# SPDX-License-Identifier: GPL-3.0-or-later
"""The table's lookups as node groups, the same formulas as ``shaders/table.osl``."""

from __future__ import annotations

import math

import bpy

from ...precompute.table.layout import TableLayout
from .node_graph import Graph, Socket, interface, new_group


def bilinear(image: bpy.types.Image, layout: TableLayout) -> bpy.types.NodeTree:
    """Group (x, y in texels) -> colour.

    Four texels by closest interpolation, blended here: a linear Image Texture in EEVEE would take
    smaller copies of the atlas where the picture is coarse, and mix tiles that have nothing to do
    with each other.
    """
    tree = new_group(f"Diffraction texels {image.name}")
    interface(tree, {"X": ("NodeSocketFloat", None), "Y": ("NodeSocketFloat", None)}, {"Value": "NodeSocketVector"})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput")
    x, y = (graph.difference(given.outputs[name], 0.5) for name in "XY")
    left, below = graph.math("FLOOR", x), graph.math("FLOOR", y)
    rows = []
    for up in (0.5, 1.5):
        texels = []
        for right in (0.5, 1.5):
            place = graph.join(
                graph.product(graph.sum(left, right), 1.0 / layout.width),
                graph.product(graph.sum(below, up), 1.0 / layout.height),
                0.0,
            )
            texture = graph.add("ShaderNodeTexImage", image=image, interpolation="Closest", extension="EXTEND")
            graph.put(texture.inputs["Vector"], place)
            texels.append(texture.outputs["Color"])
        rows.append(graph.mix(graph.difference(x, left), *texels))
    graph.put(graph.add("NodeGroupOutput").inputs["Value"], graph.mix(graph.difference(y, below), *rows))
    return tree


def _arsinh(graph: Graph, x: Socket) -> Socket:
    root = graph.math("SQRT", graph.fused(x, x, 1.0))
    return graph.math("LOGARITHM", graph.sum(x, root), math.e)


def _turn_row(graph: Graph, y: Socket, x: Socket, count: int) -> Socket:
    """Row coordinate of atan2(y, x) in [0, count)."""
    turn = graph.math("ARCTAN2", y, x)
    return graph.math("WRAP", graph.product(turn, count / (2.0 * math.pi)), float(count), 0.0)


def transform(name: str, layout: TableLayout, texels: bpy.types.NodeTree) -> bpy.types.NodeTree:
    """Group (u, v, |w|) -> XYZ of T in 1/sr."""
    tree = new_group(f"Diffraction table {name}")
    sockets = {axis: ("NodeSocketFloat", None) for axis in ("U", "V", "W")}
    interface(tree, sockets, {"XYZ": "NodeSocketVector"})
    graph = Graph(tree)
    given = graph.add("NodeGroupInput").outputs
    u, v, w = given["U"], given["V"], given["W"]
    radius = graph.math("SQRT", graph.fused(u, u, graph.product(v, v)))
    column = graph.math(
        "MINIMUM", graph.product(_arsinh(graph, graph.product(radius, 1 / layout.r0)), layout.a_r), layout.n_r - 1
    )
    row = _turn_row(graph, v, u, layout.n_phi)
    position = graph.fused(_arsinh(graph, graph.product(w, 1 / layout.w0)), layout.a_w, -layout.a_w * layout.s_w)
    position = graph.clamp(position, 0.0, layout.n_w - 1.0)
    lower = graph.math("MINIMUM", graph.math("FLOOR", position), layout.n_w - 2.0)
    values = []
    for step in (0.0, 1.0):
        index = graph.sum(lower, step)
        tile_row = graph.math("FLOOR", graph.product(graph.sum(index, 0.5), 1.0 / layout.tile_columns))
        tile_column = graph.difference(index, graph.product(tile_row, float(layout.tile_columns)))
        x = graph.sum(graph.fused(tile_column, float(layout.n_r), 0.5), column)
        y = graph.sum(graph.fused(tile_row, float(layout.tile_height), 1.5), row)
        values.append(graph.group(texels, X=x, Y=y).outputs["Value"])
    value = graph.mix(graph.difference(position, lower), *values)
    gain = graph.product(graph.math("POWER", w, layout.power), layout.scale)
    graph.put(graph.add("NodeGroupOutput").inputs["XYZ"], graph.scaled(value, gain))
    return tree


def albedo(name: str, layout: TableLayout, texels: bpy.types.NodeTree) -> bpy.types.NodeTree:
    """Group (local direction) -> directional albedo of the raw model with R = 1."""
    tree = new_group(f"Diffraction albedo {name}")
    interface(tree, {"Direction": ("NodeSocketVector", None)}, {"Albedo": "NodeSocketFloat"})
    graph = Graph(tree)
    x, y, z = graph.split(graph.add("NodeGroupInput").outputs["Direction"])
    theta = graph.math("ARCCOSINE", graph.clamp(z, 0.0, 1.0))
    column = graph.fused(theta, (layout.n_theta - 1) / (0.5 * math.pi), 0.5)
    row = graph.sum(_turn_row(graph, y, x, layout.n_albedo_phi), layout.conserving_y + 1.5)
    found = graph.group(texels, X=column, Y=row).outputs["Value"]
    graph.put(graph.add("NodeGroupOutput").inputs["Albedo"], graph.split(found)[0])
    return tree


def reflectance(name: str, layout: TableLayout, texels: bpy.types.NodeTree) -> bpy.types.NodeTree:
    """Group (cosine of the view) -> XYZ that the table's stuff keeps from below."""
    tree = new_group(f"Diffraction reflectance {name}")
    interface(tree, {"Cosine": ("NodeSocketFloat", None)}, {"XYZ": "NodeSocketVector"})
    graph = Graph(tree)
    cosine = graph.add("NodeGroupInput").outputs["Cosine"]
    theta = graph.math("ARCCOSINE", graph.clamp(cosine, 0.0, 1.0))
    column = graph.fused(theta, (layout.n_reflectance - 1) / (0.5 * math.pi), 0.5)
    found = graph.group(texels, X=column, Y=layout.reflectance_y + 0.5).outputs["Value"]
    graph.put(graph.add("NodeGroupOutput").inputs["XYZ"], found)
    return tree
