# SPDX-License-Identifier: GPL-3.0-or-later
"""Node groups made with one update for all their changes: the same as with an update after each."""

import bpy
import pytest

from tests.support.blender import node_trees, tables


@pytest.fixture
def batch(blender):
    from diffraction_shader.addon.materials import batch

    return batch


@pytest.fixture
def table(tmp_path):
    tables.make_table(tmp_path / "t.exr", tables.lobes, albedo=tables.rising)
    return tmp_path / "t.exr"


def made(make):
    """The file's groups after a call, from none."""
    bpy.data.batch_remove(list(bpy.data.node_groups))
    make()
    return node_trees.all_groups()


@pytest.mark.parametrize(
    "settings",
    [
        {"fresnel": "CONDUCTOR"},
        pytest.param({"fresnel": "DIELECTRIC"}, marks=pytest.mark.slow),
        pytest.param({"fresnel": "NONE", "conserve_energy": False}, marks=pytest.mark.slow),
    ],
)
def test_same_material_as_node_by_node(batch, table, monkeypatch, settings):
    from diffraction_shader.addon.materials import material

    chosen = material.Settings(implementation="NODES", **settings)
    at_once = made(lambda: material.table_group(table, chosen))
    monkeypatch.setattr(batch, "make", lambda work: work())
    one_by_one = made(lambda: material.table_group(table, chosen))
    assert at_once.keys() == one_by_one.keys()
    for name, tree in one_by_one.items():
        assert at_once[name] == tree, name
    assert sum(len(links) for _, _, links in at_once.values()) > 3000


def test_same_scales_as_node_by_node(batch, monkeypatch):
    from diffraction_shader.addon.materials.scales import group

    at_once = made(group.build)
    monkeypatch.setattr(batch, "make", lambda work: work())
    assert at_once == made(group.build)


def test_a_blender_that_calls_nothing_makes_the_same(batch, monkeypatch):
    from diffraction_shader.addon.materials.scales import group

    at_once = made(group.build)
    monkeypatch.setattr(batch, "_within_update", lambda work: work())
    assert made(group.build) == at_once


def outer(inner):
    """A group that adds one to what another gives."""
    from diffraction_shader.addon.materials.node_graph import Graph, interface, new_group

    tree = new_group("outer")
    interface(tree, {}, {"Out": "NodeSocketFloat"})
    graph = Graph(tree)
    node = graph.group(inner, In=2.0)
    graph.put(graph.add("NodeGroupOutput").inputs["Out"], graph.sum(node.outputs["Out"], 1.0))
    return node


def inner():
    from diffraction_shader.addon.materials.node_graph import shared_group

    sockets = {"In": ("NodeSocketFloat", None)}, {"Out": "NodeSocketFloat"}
    return shared_group("inner", *sockets, lambda graph, given, wanted: graph.put(wanted["Out"], given["In"]))


def test_no_tree_is_brought_up_to_date_meanwhile(batch):
    sockets = []

    def work():
        node = outer(inner())
        sockets.append(len(bpy.data.node_groups["outer"].nodes[node.name].inputs))
        return node.name

    name = batch.make(work)
    node = bpy.data.node_groups["outer"].nodes[name]
    assert sockets == [0] and len(node.inputs) == 1 and node.inputs["In"].default_value == 2.0
    assert len(bpy.data.node_groups["inner"].links) == 1 and len(bpy.data.node_groups["outer"].links) == 2
    assert [tree.name for tree in bpy.data.node_groups] == ["inner", "outer"]
    assert not hasattr(bpy.types, "DIFFRACTION_batch")


def test_what_fails_leaves_no_half_group_behind(batch):
    def work():
        inner()
        raise ValueError("no more nodes")

    with pytest.raises(ValueError, match="no more nodes"):
        batch.make(work)
    assert batch.current is None
    assert [(tree.name, len(tree.nodes)) for tree in bpy.data.node_groups] == [("inner", 0)]
    assert [len(inner().nodes), len(inner().links)] == [2, 1]
