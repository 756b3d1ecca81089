# SPDX-License-Identifier: GPL-3.0-or-later
"""An output node of EEVEE's own, which reads the node's output *EEVEE*.

`BSDF` is right in every renderer, but EEVEE makes a shader of all that leads to an output, the lobes of Cycles too:
many minutes, most of them in Blender's own handling of 13,000 nodes and of the shader's text. No factor leaves nodes
out of that which Cycles would not see as well; only outputs say for whom they are. The main one is then for Cycles:
Blender unrolls all that leads to an output for any renderer, and takes it out again node by node.
"""

from __future__ import annotations

from typing import Any

import bpy

from . import interface

#: The name of the output node.
NAME = "EEVEE Output"

#: Marks the output node as ours.
_OURS = "diffraction"

#: What the output node takes from the material's main one.
_SHARED = ("Volume", "Displacement", "Thickness")


def connect(tree: bpy.types.NodeTree, node: Any, wanted: bool) -> None:
    """Give a material the output, where its node goes straight to the surface; or take it away.

    Parameters
    ----------
    tree
        Of the material.
    node
        The node *Diffraction*.
    wanted
        Whether its implementation has a shader for EEVEE.
    """
    own, main = _own(tree), tree.get_output_node("CYCLES")
    if not wanted:
        if own is not None:
            tree.nodes.remove(own)
        _give_back(tree)
        return
    others = [each for each in tree.nodes if _is_for_eevee(each) and each != own]
    straight = main is not None and any(link.from_node == node for link in main.inputs["Surface"].links)
    if others or not straight or node.id_data != tree or interface.EEVEE not in node.outputs:
        return
    if own is None:
        own = tree.nodes.new("ShaderNodeOutputMaterial")
        own.name = own.label = NAME
        own[_OURS] = True
        own.target = "EEVEE"
        own.location = (main.location.x, main.location.y - 180.0)
    tree.links.new(node.outputs[interface.EEVEE], own.inputs["Surface"])
    if main.target == "ALL":
        main.target = "CYCLES"
        main[_OURS] = True
    follow(tree)


def follow(tree: bpy.types.NodeTree) -> None:
    """Volume and displacement are those of the main output; an output that shows nothing any more goes."""
    own = _own(tree)
    if own is not None and not own.inputs["Surface"].links:
        tree.nodes.remove(own)
        own = None
    if own is None:
        _give_back(tree)
        return
    main = tree.get_output_node("CYCLES")
    for name in _SHARED if main is not None else ():
        if name not in main.inputs:
            continue
        theirs, ours = (each.inputs[name].links for each in (main, own))
        if [link.from_socket for link in theirs] == [link.from_socket for link in ours]:
            continue
        for link in list(ours):
            tree.links.remove(link)
        for link in theirs:
            tree.links.new(link.from_socket, own.inputs[name])


def _give_back(tree: bpy.types.NodeTree) -> None:
    """The main output is for every renderer again, where none is for EEVEE."""
    if any(_is_for_eevee(each) for each in tree.nodes):
        return
    for each in tree.nodes:
        if each.bl_idname == "ShaderNodeOutputMaterial" and each.get(_OURS):
            node: Any = each
            if node.target == "CYCLES":
                node.target = "ALL"
            del node[_OURS]


def _own(tree: bpy.types.NodeTree) -> Any:
    node = tree.nodes.get(NAME)
    return node if node is not None and _is_for_eevee(node) and node.get(_OURS) else None


def _is_for_eevee(node: Any) -> bool:
    return node.bl_idname == "ShaderNodeOutputMaterial" and node.target == "EEVEE"
