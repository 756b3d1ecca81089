# SPDX-License-Identifier: GPL-3.0-or-later
"""*Snake Scales* in a material: the node with a species' values, and its links to the node *Diffraction*."""

from __future__ import annotations

from typing import Any

import bpy

from ....precompute.errors import ParameterError
from ...versions import give_nodes
from ..node import group as diffraction
from ..scale import length
from . import group, measure
from .species import SPECIES

#: Where the outputs go; of the same names on both nodes.
LINKS = ("Base", "Normal", "Tangent", "Rotation", "Mask")

#: Scales along the longest side of a mesh on which real ones are too large or too small; what is too few, too many.
ALONG, FEWEST, MOST = 40.0, 8.0, 400.0


def find(tree: bpy.types.NodeTree | None) -> Any:
    """The node of a material, None where it has none."""
    nodes = tree.nodes if tree is not None else ()
    return next((n for n in nodes if n.bl_idname == "ShaderNodeGroup" and group.is_scales(n.node_tree)), None)


def add(
    material: bpy.types.Material,
    species: str = "SUNBEAM",
    space: str = "OBJECT",
    ob: bpy.types.Object | None = None,
    scale_size_m: float = 0.0,
) -> tuple[Any, str]:
    """Give a material the node, or the one that it has another species' values; wired to *Diffraction* if there is one.

    Parameters
    ----------
    material
        Edited in place.
    species
        One of ``SPECIES``.
    space
        ``OBJECT``, for any mesh, or ``UV``, for a body whose UV map runs along it and once around it.
    ob
        Whose size and UV map are measured; None keeps the species' own sizes.
    scale_size_m
        Length of a scale; 0 takes the snake's own, or a fortieth of an object on which those could not be seen.

    Returns
    -------
    node, sentence
        The sentence says what was chosen.

    Raises
    ------
    ParameterError
        If there is no such species, or no UV map that could be measured.
    """
    if species not in SPECIES:
        raise ParameterError(f"There is no snake '{species}'; choose one of {', '.join(SPECIES)}.")
    snake = SPECIES[species]
    body = measure.uv_map(ob) if ob is not None and space == "UV" else None
    tree = give_nodes(material)
    node = find(tree)
    if node is None:
        node = tree.nodes.new("ShaderNodeGroup")
        node.name = node.label = group.NAME
        node.width = 180.0
    node.node_tree = group.build()
    inputs = node.inputs
    for name, value in snake.values.items():
        inputs[name].default_value = (*value, 1.0) if isinstance(value, tuple) else value
    inputs["Space"].default_value = int(space == "OBJECT")
    size, why = _size(inputs, ob, body, scale_size_m)
    inputs["Scale Size"].default_value = size
    if body is not None:
        inputs["Length"].default_value, inputs["Girth"].default_value = body.length_m, body.girth_m
        inputs["Along"].default_value = int(body.along_v)
    elif space == "UV":
        inputs["Length"].default_value = 12.0 * inputs["Girth"].default_value
    wire(tree)
    return node, f"{snake.label}: scales {length(size)} long, {why}"


def is_wired(tree: bpy.types.NodeTree) -> bool:
    """Whether the scales' pigment lies under *Diffraction*."""
    scales, shown = find(tree), diffraction.find(tree)
    base = shown.inputs["Base"] if shown is not None else None
    return bool(scales is not None and base is not None and any(link.from_node == scales for link in base.links or ()))


def _size(inputs: Any, ob: bpy.types.Object | None, body: measure.Body | None, given_m: float) -> tuple[float, str]:
    """Length of a scale in metres, and why."""
    own = inputs["Scale Size"].default_value
    if given_m:
        return given_m, "as given"
    if body is not None:
        ratio = body.girth_m / inputs["Girth"].default_value
        if not 0.5 < ratio < 2.0:
            return own * ratio, f"the snake's own in proportion to a girth of {length(body.girth_m)}"
    elif ob is not None:
        longest = measure.longest_m(ob)
        if longest and not FEWEST < longest / own < MOST:
            return longest / ALONG, f"a fortieth of {ob.name}, on which the snake's own of {length(own)} were not seen"
    return own, "the snake's own"


def wire(tree: Any) -> None:
    """Link the scales' node to *Diffraction* where both are in a tree.

    A pigment that *Apply* made goes, and the scales' takes the place of another shader; without *Diffraction* the
    pigment alone goes to the material's output. Tangent, Rotation and Mask that the user linked otherwise stay.
    """
    scales, shown = find(tree), diffraction.find(tree)
    if scales is None:
        return
    if shown is None or shown.id_data != tree:
        output = tree.get_output_node("CYCLES") or tree.nodes.new("ShaderNodeOutputMaterial")
        if not scales.outputs["Base"].is_linked:
            tree.links.new(scales.outputs["Base"], output.inputs["Surface"])
            scales.location = (output.location.x - 240.0, output.location.y)
        return
    for name in LINKS:
        socket = shown.inputs[name]
        source = socket.links[0].from_node if socket.is_linked and socket.links else None
        if name in ("Tangent", "Rotation", "Mask") and source not in (None, scales):
            continue
        tree.links.new(scales.outputs[name], socket)
        if source is not None and source != scales and not any(out.is_linked for out in source.outputs):
            if source.name == "Pigment":
                tree.nodes.remove(source)
    if any(link.from_node == scales for link in shown.inputs["Tangent"].links or ()):
        shown.inputs["TangentIsDirection"].default_value = 1
    if scales.location.x > shown.location.x - 220.0:
        scales.location = (shown.location.x - 240.0, shown.location.y)
