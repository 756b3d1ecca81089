# SPDX-License-Identifier: GPL-3.0-or-later
"""The node groups *Diffraction*: one for each table and implementation, shared by all materials that use it.

A group holds all that belongs to the table: the script node or the nodes, the images, and the attributes that read the
scene's lights. It has the sockets of `interface` and knows its table by custom properties. A material has one of them
as its node, on the top level or inside groups of the user's own.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from typing import Any

import bpy

from ....precompute.errors import DiffractionError
from ....precompute.light.colour import table_light, xyz_to_rgb_matrix
from ....precompute.light.illuminant import to_json
from ....precompute.table.layout import TableLayout
from ...colour_spaces import working_space
from ...versions import tells_mirrored_uv
from .. import batch, nodes_twin, osl, script_node
from ..node_graph import Graph
from . import frame, interface, keys, lamp_nodes

#: Name of the node that holds a material's diffraction.
NODE = "Diffraction"

#: The script node inside a group.
SCRIPT = "OSL"


def is_group(tree: bpy.types.NodeTree | None) -> bool:
    """Whether a node group is one of ours."""
    return tree is not None and keys.TABLE in tree


def trees() -> list[bpy.types.NodeTree]:
    """All groups of ours in the file."""
    return [tree for tree in bpy.data.node_groups if keys.TABLE in tree]


def find(tree: bpy.types.NodeTree | None) -> bpy.types.Node | None:
    """The node of ours in a tree, the one called *Diffraction* first, else any, those within other groups last."""
    return next(_find(tree, set()), None) if tree is not None else None


def _find(tree: bpy.types.NodeTree, seen: set[bpy.types.NodeTree]) -> Iterator[bpy.types.Node]:
    if tree in seen:
        return
    seen.add(tree)
    named = tree.nodes.get(NODE)
    if named is not None and is_group(getattr(named, "node_tree", None)):
        yield named
    groups = [node for node in tree.nodes if node.bl_idname == "ShaderNodeGroup" and node.node_tree is not None]
    for node in groups:
        if is_group(node.node_tree):
            yield node
    for node in groups:
        if not is_group(node.node_tree):
            yield from _find(node.node_tree, seen)


def owner(material: bpy.types.Material) -> Any:
    """What knows a material's table: the group of its node, or the material itself if version 0.1.0 made it."""
    node = find(material.node_tree)
    if node is not None:
        return node.node_tree
    return material if keys.TABLE in material and material.node_tree is not None else None


def script_of(tree: bpy.types.NodeTree) -> bpy.types.Node | None:
    """The script node of a group (or of a material of version 0.1.0), None where it has none."""
    return tree.nodes.get(SCRIPT) or tree.nodes.get(NODE)


def build(
    stem: str,
    implementation: str,
    images: tuple[bpy.types.Image, bpy.types.Image | None],
    sidecar: dict[str, Any],
    fresnel: str,
    conserve: bool,
    albedo_free: float = 2.0,
) -> bpy.types.NodeTree:
    """The group of a table: the one that is there, built anew where the table or the extension has changed.

    Parameters
    ----------
    stem
        Name of the table.
    implementation
        ``OSL`` or ``NODES``.
    images
        Atlas and image of directions.
    sidecar
        Of the table.
    fresnel, conserve
        Built into the nodes of ``NODES``.
    albedo_free
        See `osl.source`.

    Raises
    ------
    DiffractionError
        If this Blender cannot compile OSL.
    """
    layout, albedo_max = TableLayout.from_dict(sidecar["layout"]), float(sidecar["albedo_max"])
    light = table_light(sidecar["colour"])
    own = None if light == "D65" else light  # else the scene's matrix serves
    light = light if isinstance(light, str) else json.dumps(to_json(light))
    image, directions = images
    variant = json.dumps([fresnel, conserve] if implementation == "NODES" else [])
    source = (
        osl.source(layout, albedo_max, albedo_free=albedo_free)
        if implementation == "OSL"
        else f"{nodes_twin.VERSION} {albedo_free!r}"
    )
    sockets = [socket.name for socket in interface.SOCKETS]
    made_from = [sidecar["atlas"]["sha256"], source, light, sidecar["layout"], sockets]
    stamp = hashlib.sha256(json.dumps(made_from, sort_keys=True).encode()).hexdigest()
    found = _existing(image, implementation, variant)
    tree = found or bpy.data.node_groups.new(f"Diffraction {stem}", "ShaderNodeTree")
    if found is None or tree[keys.STAMP] != stamp:
        interface.make(tree)
        try:
            if implementation == "OSL":
                _fill_with_osl(tree, stem, source, own)
                _mask(tree)
            else:
                _fill_with_nodes(tree, stem, images, layout, albedo_max, fresnel, conserve, own, albedo_free)
        except Exception:
            if found is None:
                bpy.data.node_groups.remove(tree)
            raise
    tree[keys.TABLE], tree[keys.ATLAS], tree[keys.SHA256] = image.filepath, image, sidecar["atlas"]["sha256"]
    if directions is not None:
        tree[keys.IMPORTANCE] = directions
    tree[keys.IMPLEMENTATION], tree[keys.VARIANT], tree[keys.STAMP] = implementation, variant, stamp
    tree[keys.ILLUMINANT] = light
    return tree


def _mask(tree: bpy.types.NodeTree) -> None:
    """The pigment alone where the mask is 0, as in `nodes_twin.build`; one of 1 that is not linked costs nothing."""
    graph = Graph(tree)
    out: Any = next(node for node in tree.nodes if node.bl_idname == "NodeGroupOutput")
    given = graph.add("NodeGroupInput", label="Mask")
    out.location.x += 240.0
    for row, name in enumerate((interface.OUTPUT, interface.EEVEE)):
        shaded = out.inputs[name]
        source = shaded.links[0].from_socket
        if source.node.bl_idname == "NodeGroupInput":  # the pigment itself
            continue
        mix = graph.add("ShaderNodeMixShader", label="Where the structure is")
        for socket, value in zip(mix.inputs, (given.outputs["Mask"], given.outputs["Base"], source), strict=True):
            tree.links.new(value, socket)
        tree.links.new(mix.outputs[0], shaded)
        mix.location = (out.location.x - 180.0, out.location.y - 160.0 * row)
    given.location = (out.location.x - 180.0, out.location.y + 60.0)


def _existing(image: bpy.types.Image, implementation: str, variant: str) -> bpy.types.NodeTree | None:
    wanted = (image, implementation, variant)
    for tree in trees():
        if tree.library is None and (tree.get(keys.ATLAS), tree[keys.IMPLEMENTATION], tree[keys.VARIANT]) == wanted:
            return tree
    return None


def _fill_with_nodes(tree: bpy.types.NodeTree, *of_table: Any) -> None:
    batch.make(lambda: nodes_twin.build(tree, *of_table))


def _fill_with_osl(tree: bpy.types.NodeTree, stem: str, source: str, own: Any) -> None:
    graph = Graph(tree)
    script = graph.add("ShaderNodeScript", label=f"Table {stem}")
    try:
        script_node.fill(script, _source_text(stem, source))
    except DiffractionError:
        tree.nodes.remove(script)  # what was there stays
        raise
    for old in [node for node in tree.nodes if node != script]:
        tree.nodes.remove(old)
    script.name = SCRIPT
    given = graph.add("NodeGroupInput", label="Settings")
    for socket in interface.SOCKETS:
        if socket.name in script.inputs:
            tree.links.new(given.outputs[socket.name], script.inputs[socket.name])
    surface = _uv_frame(tree, script)

    lights = [lamp_nodes.lamp(graph, slot) for slot in range(1, osl.LAMPS_MAX + 1)]
    for slot, node in enumerate(lights, 1):
        for name in lamp_nodes.OUTPUTS:
            tree.links.new(node.outputs[name], script.inputs[f"Lamp{slot}{name}"])
    number: Any = lamp_nodes.count(graph)
    tree.links.new(number, script.inputs["LampCount"])
    rows: Any = lamp_nodes.matrix(graph, own)
    for row, name in zip(rows, ("ToRed", "ToGreen", "ToBlue"), strict=True):
        tree.links.new(row, script.inputs[name])

    # EEVEE knows no OSL: there the pigment shows.
    out = graph.add("NodeGroupOutput")
    # Nor does Cycles without Open Shading Language, which then takes the factor's own value 0.
    runs: Any = graph.add("ShaderNodeMixShader", label="OSL runs")
    runs.inputs[0].default_value = 0.0
    for socket, value in zip(
        runs.inputs, (script.outputs["Runs"], given.outputs["Base"], script.outputs["BSDF"]), strict=True
    ):
        tree.links.new(value, socket)
    choice: list[Any] = [runs, *nodes_twin.by_engine(graph, runs.outputs[0], given.outputs["Base"])]
    tree.links.new(choice[-1].outputs[0], out.inputs[interface.OUTPUT])
    tree.links.new(given.outputs["Base"], out.inputs[interface.EEVEE])

    given.location, script.location, out.location = (-300.0, 0.0), (300.0, 0.0), (900.0, 0.0)
    given.hide = script.hide = out.hide = False
    script.width = 260.0
    _column(surface, (-20.0, 200.0))
    _column([row.node for row in (*rows, number)], (-20.0, -560.0))
    _column(lights, (-20.0, -820.0))
    _column(choice, (640.0, 200.0))
    _frame(tree, "UV map", surface)
    _frame(tree, "Colours: XYZ to the working space" if own is not None else "Colours and number of lamps",
           [row.node for row in rows] + ([] if own is not None else [number.node]))  # fmt: skip
    _frame(tree, "Lamps of the scene", lights)
    _frame(tree, "Table", [script])
    _frame(tree, "Pigment in EEVEE and without OSL", choice)


def _uv_frame(tree: bpy.types.NodeTree, script: bpy.types.Node) -> list[bpy.types.Node]:
    """The frame of the active UV map, for a node without a tangent."""
    tangent: Any
    sign: Any
    if tells_mirrored_uv():
        tangent, sign = frame.uv_directions(tree)
        script.inputs["UVIsDirection"].default_value = 1
        second = "UVHandedness"
    else:
        tangent, sign = frame.uv_frame(tree)
        second = "UVBitangent"
    tree.links.new(tangent, script.inputs["UVTangent"])
    tree.links.new(sign, script.inputs[second])
    for socket in (tangent, sign):
        socket.node.hide = True
    return [tangent.node, sign.node]


def follow_working_space() -> None:
    """Groups with a matrix of their own follow the working space of the file; the others read the scene's."""
    for tree in trees():
        if tree.nodes.get(lamp_nodes.OWN_MATRIX[0]) is None or not tree.is_editable:
            continue
        for name, row in zip(
            lamp_nodes.OWN_MATRIX, xyz_to_rgb_matrix(working_space(), tree[keys.ILLUMINANT]), strict=True
        ):
            for socket, value in zip(tree.nodes[name].inputs, row, strict=True):
                if socket.default_value != float(value):
                    socket.default_value = float(value)


def _source_text(stem: str, source: str) -> bpy.types.Text:
    name = f"diffraction {stem}.osl"
    text = bpy.data.texts.get((name, None)) or bpy.data.texts.new(name)
    if text.as_string() != source:
        text.clear()
        text.write(source)
    return text


def _column(nodes: list[bpy.types.Node], at: tuple[float, float], step: float = 44.0) -> None:
    for row, node in enumerate(nodes):
        node.location = (at[0], at[1] - step * row)


def _frame(tree: bpy.types.NodeTree, label: str, nodes: list[bpy.types.Node]) -> None:
    around = tree.nodes.new("NodeFrame")
    around.label = around.name = label
    for node in nodes:
        node.parent = around
