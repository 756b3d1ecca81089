# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of version 0.1.0: their node with drivers to the lamps of one scene becomes the node of today.

Values, links, keys and drivers of sockets that both have stay; those of lamps and of the matrix go. A material whose
table is missing stays as it is: it renders as 0.1.0 left it, with the lamps that it knows.
"""

from __future__ import annotations

import re
from typing import Any

import bpy

from ....precompute.errors import DiffractionError
from ...tables import recipe
from .. import material as materials
from . import eevee_output, frame, group, interface, keys

_SOCKET = re.compile(r'^nodes\["Diffraction"\]\.inputs\[(\d+)\]\.default_value$')


def old_materials() -> list[bpy.types.Material]:
    """Materials of 0.1.0 that can be edited."""
    return [m for m in bpy.data.materials if keys.TABLE in m and m.is_editable and group.owner(m) is m]


def migrate_all() -> list[str]:
    """Bring over all that can be; a sentence without a full stop for what was done, and for each that could not."""
    done, said = [], []
    for material in old_materials():
        try:
            migrate(material)
            done.append(material.name)
        except DiffractionError as error:
            said.append(f"{material.name} stays as version 0.1.0 made it: {error}".rstrip("."))
    if done:
        said.insert(0, f"Brought over from version 0.1.0: {', '.join(done)}")
    return said


def migrate(material: bpy.types.Material) -> None:
    """Bring one material over.

    Raises
    ------
    DiffractionError
        If its table cannot be read.
    """
    tree: Any = material.node_tree
    old = tree.nodes.get(group.NODE)
    if old is None:
        del material[keys.TABLE]
        return
    names = [socket.name for socket in old.inputs]
    settings = materials.settings_of(material)
    made = materials.table_group(materials.table_path(material), settings)
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.label, node.width = made, group.NODE, 200.0
    node.location, node.parent = old.location, old.parent
    known = {socket.name for socket in interface.SOCKETS}
    for socket in old.inputs:
        if socket.name not in known:
            continue
        target = node.inputs[socket.name]
        for link in list(socket.links):
            tree.links.new(link.from_socket, target)
        if hasattr(socket, "default_value") and hasattr(target, "default_value"):
            target.default_value = socket.default_value
    if settings.implementation == "NODES":
        node.inputs["Environment"].default_value = 0  # nodes of 0.1.0 saw lamps alone: the picture stays
    for output in ("BSDF",):
        for link in list(old.outputs[output].links):
            tree.links.new(node.outputs[output], link.to_socket)
    second = tree.nodes.get(eevee_output.NAME)
    if second is not None:
        tree.nodes.remove(second)
        for each in tree.nodes:
            if each.bl_idname == "ShaderNodeOutputMaterial" and each.target == "CYCLES":
                each.target = "ALL"
    tree.nodes.remove(old)
    node.name = group.NODE
    _renumber(tree, names, [socket.name for socket in node.inputs])
    _simplify(tree, node, settings)
    eevee_output.connect(tree, node, settings.implementation == "NODES")
    if recipe.KEY in material and recipe.KEY not in made:
        made[recipe.KEY] = material[recipe.KEY]
    for key in (keys.TABLE, keys.ATLAS, keys.IMPORTANCE, keys.SHA256, keys.ILLUMINANT, recipe.KEY):
        if key in material:
            del material[key]


def _renumber(tree: Any, before: list[str], after: list[str]) -> None:
    """Keys and drivers name a socket by its number: they follow the name."""
    animation = tree.animation_data
    if animation is None:
        return
    curves = [(animation.drivers, curve) for curve in animation.drivers]
    if animation.action is not None:
        for layer in getattr(animation.action, "layers", ()):
            for strip in layer.strips:
                for bag in getattr(strip, "channelbags", ()):
                    curves += [(bag.fcurves, curve) for curve in bag.fcurves]
    for owner, curve in curves:
        found = _SOCKET.match(curve.data_path)
        if found is None:
            continue
        number = int(found.group(1))
        name = before[number] if number < len(before) else ""
        if name in after:
            curve.data_path = f'nodes["Diffraction"].inputs[{after.index(name)}].default_value'
        else:
            owner.remove(curve)


def _simplify(tree: Any, node: Any, settings: materials.Settings) -> None:
    """The frame of the active UV map stands inside the group now."""
    if settings.orientation not in {"UV", "TEXTURE"} or settings.uv_map:
        return
    for name in (frame.TANGENT, frame.BITANGENT, frame.HANDEDNESS):
        old = tree.nodes.get(name)
        if old is not None:
            tree.nodes.remove(old)
    node.inputs["TangentIsDirection"].default_value = 0
