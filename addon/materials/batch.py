# SPDX-License-Identifier: GPL-3.0-or-later
"""Many changes of node trees with one update of Blender's, where it otherwise looks through a tree after each.

Adding a node or a link from Python brings the whole tree up to date, so that a tree of n nodes takes n^2. While one
update is going on Blender begins no other, for the sake of Python that changes trees in the ``update`` of a tree of its
own. There the changes are made. Nothing depends on that: a Blender that does it otherwise makes the same, slower.

What an update alone brings are the sockets of groups, of their inputs and outputs; `Later` names them until then.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import bpy

_SOCKET = bpy.types.NodeSocket

#: Nodes whose sockets come with an update.
GROUPS = {"ShaderNodeGroup", "NodeGroupInput", "NodeGroupOutput"}


@dataclass(frozen=True)
class Later:
    """A socket of a group's node that comes with the next update."""

    node: bpy.types.Node
    side: str
    name: str

    def socket(self) -> Any:
        """The socket, once it is there."""
        return getattr(self.node, self.side)[self.name]


class _Sockets:
    def __init__(self, node: bpy.types.Node, side: str) -> None:
        self._node, self._side = node, side

    def __getitem__(self, name: str) -> Later:
        return Later(self._node, self._side, name)


class Unfinished:
    """A node of a group: its sockets by their names are `Later`, all else is the node's own."""

    def __init__(self, node: bpy.types.Node) -> None:
        self._node = node
        self.inputs, self.outputs = _Sockets(node, "inputs"), _Sockets(node, "outputs")

    def __getattr__(self, name: str) -> Any:
        return getattr(self._node, name)


@dataclass
class Batch:
    """Changes that are being made.

    Parameters
    ----------
    trees
        That change, each once, in the order of their first change.
    waiting
        Socket and what it takes, where one of them is `Later`.
    places
        Of new nodes, by their pointers.
    linked
        Pointers of the inputs that have a link.
    """

    trees: dict[str, bpy.types.NodeTree] = field(default_factory=dict)
    waiting: list[tuple[Any, Any]] = field(default_factory=list)
    places: dict[int, tuple[float, float]] = field(default_factory=dict)
    linked: set[int] = field(default_factory=set)


#: The batch that is being made; None: every change is brought up to date by itself.
current: Batch | None = None


def make(work: Callable[[], Any]) -> Any:
    """Run what adds nodes by `node_graph.Graph`, without an update after each; what it returns.

    Parameters
    ----------
    work
        Adds the nodes. What it leaves is whole only when this returns.
    """
    global current
    if current is not None:
        return work()
    batch = current = Batch()
    try:
        made = _within_update(work)
        if not all(_is_there(each) for pair in batch.waiting for each in pair):
            _bring_up_to_date(batch)
        _put_all(batch)
        _put_in_place(batch)
    except BaseException:
        for tree in batch.trees.values():  # half a group is none: `node_graph.shared_group` makes an empty one anew
            tree.nodes.clear()
        raise
    finally:
        current = None
    return made


def changes(tree: bpy.types.NodeTree) -> None:
    """A tree is about to change."""
    if current is not None:
        current.trees.setdefault(tree.name, tree)


def place(node: bpy.types.Node, at: tuple[float, float]) -> None:
    """Where a node lies in its tree.

    Blender 5.2 looks through the whole tree for each place that is set alone.
    """
    if current is None:
        node.location = at
    else:
        current.places[node.as_pointer()] = at


def of_group(node: bpy.types.Node) -> bpy.types.Node:
    """A new node of those in `GROUPS`, as it can be used now."""
    stand_in: Any = Unfinished(node) if current is not None else node
    return stand_in


def put(socket: Any, value: Any) -> None:
    """Link a socket to a value, or set it; now, or once both are there."""
    if isinstance(socket, Later) or isinstance(value, Later):
        assert current is not None, "a socket of a batch that is over"
        current.waiting.append((socket, value))
    elif isinstance(value, _SOCKET):
        _link(socket, value)
    elif socket.type == "RGBA" and not isinstance(value, float):
        socket.default_value = (*value, 1.0) if len(value) == 3 else value
    else:
        socket.default_value = value


def _link(socket: Any, value: Any) -> None:
    """Blender counts the links of a socket before it adds one, among all of the tree; a new one has none."""
    tree: Any = socket.id_data
    if current is None or (pointer := socket.as_pointer()) in current.linked:
        tree.links.new(value, socket)
    else:
        tree.links.new(value, socket, verify_limits=False)
        current.linked.add(pointer)


def _put_all(batch: Batch) -> None:
    """Make what was waiting, and leave all trees up to date.

    Blender brings all of them up to date in one go when the tree of `_within_update` goes, in a tenth of the time that
    one after the other takes. A tree that changes with them tells whether it did: a root has one socket, a sum two.
    """
    witness: Any = bpy.data.node_groups.new("Diffraction witness", "ShaderNodeTree")
    try:
        node: Any = witness.nodes.new("ShaderNodeMath")

        def work() -> bool:
            for socket, value in batch.waiting:
                put(_found(socket), _found(value))
            node.operation = "SQRT"
            return True

        _within_update(work)
        if node.inputs[1].enabled:
            _bring_up_to_date(batch)
    finally:
        bpy.data.node_groups.remove(witness)


def _found(socket: Any) -> Any:
    return socket.socket() if isinstance(socket, Later) else socket


def _is_there(value: Any) -> bool:
    """5.2 makes the sockets of groups with the node, 4.5 with an update."""
    return not isinstance(value, Later) or value.name in getattr(value.node, value.side)


def _put_in_place(batch: Batch) -> None:
    for tree in batch.trees.values():
        at = [batch.places.get(node.as_pointer()) or tuple(node.location) for node in tree.nodes]
        tree.nodes.foreach_set("location", [number for place in at for number in place])


def _bring_up_to_date(batch: Batch) -> None:
    for tree in batch.trees.values():
        tree.interface_update(bpy.context)


def _within_update(work: Callable[[], Any]) -> Any:
    """What a callable returns, run while Blender brings a tree up to date that is there for that alone."""
    made: list[Any] = []
    failed: list[BaseException] = []

    def once() -> None:
        if not made and not failed:
            try:
                made.append(work())
            except BaseException as error:  # Blender would print it and go on
                failed.append(error)

    class DIFFRACTION_batch(bpy.types.NodeTree):
        bl_idname = "DIFFRACTION_BATCH"
        bl_label = "Diffraction"
        bl_icon = "NODETREE"

        @classmethod
        def poll(cls, context: bpy.types.Context) -> bool:
            return False

        def update(self) -> None:
            once()

    # For no longer than it takes: 4.5 does not end while a tree's class of a script is registered.
    bpy.utils.register_class(DIFFRACTION_batch)
    try:
        tree = bpy.data.node_groups.new("Diffraction batch", DIFFRACTION_batch.bl_idname)
        try:
            tree.nodes.new("NodeReroute")
        finally:
            bpy.data.node_groups.remove(tree)
    finally:
        bpy.utils.unregister_class(DIFFRACTION_batch)
    once()
    if failed:
        raise failed[0]
    return made[0]
