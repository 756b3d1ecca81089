# SPDX-License-Identifier: GPL-3.0-or-later
"""All of a file's node groups as plain values, to compare."""

import bpy

_PROPERTIES = (
    "operation", "data_type", "node_tree", "image", "interpolation", "extension", "attribute_name", "attribute_type",
    "clamp_factor", "distribution", "noise_dimensions", "component", "mode", "space", "uv_map", "direction_type",
    "vector_type", "convert_from", "convert_to", "label", "hide",
)  # fmt: skip


def all_groups():
    """Name of each group: its interface, nodes with sockets and values, links."""
    return {tree.name: (_interface(tree), _nodes(tree), _links(tree)) for tree in bpy.data.node_groups}


def _plain(value):
    if isinstance(value, bpy.types.ID):
        return value.name
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _interface(tree):
    return [
        (item.item_type, item.name, getattr(item, "in_out", ""), getattr(item, "socket_type", ""))
        for item in tree.interface.items_tree
    ]


def _nodes(tree):
    return {
        node.name: (
            node.bl_idname,
            tuple(node.location),
            {name: _plain(getattr(node, name)) for name in _PROPERTIES if hasattr(node, name)},
            [(each.identifier, each.enabled, _plain(getattr(each, "default_value", None))) for each in node.inputs],
            [(each.identifier, each.enabled) for each in node.outputs],
        )
        for node in tree.nodes
    }


def _links(tree):
    return {
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier, link.is_valid)
        for link in tree.links
    }
