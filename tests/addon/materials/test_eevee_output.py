# SPDX-License-Identifier: GPL-3.0-or-later
"""EEVEE reads an output of its own, which leads to none of the nodes that Cycles needs."""

import bpy
import pytest

from tests.support.blender import materials, scenes, tables


@pytest.fixture
def made(blender, tmp_path):
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    return materials.diffracting(scenes.add_plane(), tmp_path / "t.exr", "NODES")


def reached(socket):
    """The nodes that lead to a socket, those of groups too."""
    seen, todo, found = set(), [socket], []
    while todo:
        for link in todo.pop().links:
            node, source = link.from_node, link.from_socket
            if node.bl_idname == "ShaderNodeGroup":
                if (node, source.identifier) in seen:
                    continue
                seen.add((node, source.identifier))
                end = next(n for n in node.node_tree.nodes if n.bl_idname == "NodeGroupOutput")
                found += reached(end.inputs[source.name])
            elif node in seen:
                continue
            seen.add(node)
            found.append(node)
            todo += node.inputs
    return found


def of_eevee(tree):
    return tree.get_output_node("EEVEE")


def test_eevee_sees_a_small_part_of_the_nodes(made):
    tree = made.node_tree
    eevee, cycles = (tree.get_output_node(name).inputs["Surface"] for name in ("EEVEE", "CYCLES"))
    assert eevee.links[0].from_socket.name == "EEVEE"
    assert cycles.links[0].from_socket.name == "BSDF"
    assert 100 < len(reached(eevee)) < 0.3 * len(reached(cycles))


def test_linear_lookups_stand_still_in_eevee(made):
    """EEVEE looks up both ways and drops one; filtered between random places that takes minutes without a GPU."""
    nodes = reached(made.node_tree.get_output_node("EEVEE").inputs["Surface"])
    linear = [n for n in nodes if n.bl_idname == "ShaderNodeTexImage" and n.interpolation == "Linear"]
    assert linear
    for node in linear:
        (place,) = node.inputs["Vector"].links
        if place.from_node.bl_idname == "ShaderNodeCombineXYZ":  # of a guard, one for all
            assert not any(socket.is_linked for socket in place.from_node.inputs)
            continue
        assert place.from_node.operation == "MULTIPLY"
        difference = place.from_node.inputs[1].links[0].from_node
        assert (difference.operation, difference.inputs[0].default_value) == ("SUBTRACT", 1.0)
        assert difference.inputs[1].links[0].from_socket.name == "EEVEE"


def test_the_output_goes_with_the_node(made):
    tree = made.node_tree
    pigment = tree.nodes["Pigment"].outputs[0]
    tree.nodes.remove(tree.nodes["Diffraction"])
    tree.links.new(pigment, tree.get_output_node("CYCLES").inputs["Surface"])
    made.update_tag()
    bpy.context.view_layer.update()
    assert of_eevee(tree).target == "ALL"


def test_blender_unrolls_for_eevee_what_eevee_needs(made):
    """An output for any renderer would be unrolled too, 11,000 nodes that are taken out again one by one."""
    tree = made.node_tree
    assert [n.target for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial"] == ["CYCLES", "EEVEE"]


def test_without_the_output_the_main_one_is_for_all_again(made):
    tree = made.node_tree
    tree.nodes.remove(of_eevee(tree))
    made.update_tag()
    bpy.context.view_layer.update()
    assert of_eevee(tree) == tree.get_output_node("CYCLES")
    assert of_eevee(tree).target == "ALL"


def test_displacement_is_that_of_the_main_output(made):
    tree = made.node_tree
    relief = tree.nodes.new("ShaderNodeDisplacement")
    main = tree.get_output_node("CYCLES").inputs["Displacement"]
    tree.links.new(relief.outputs[0], main)
    bpy.context.view_layer.update()
    assert of_eevee(tree).inputs["Displacement"].links[0].from_node == relief
    tree.links.remove(main.links[0])
    bpy.context.view_layer.update()
    assert not of_eevee(tree).inputs["Displacement"].links


def test_an_output_of_the_users_own_stays(blender, tmp_path):
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    material = bpy.data.materials.new("own")
    from diffraction_shader.addon.versions import give_nodes

    nodes = give_nodes(material).nodes
    theirs = nodes.new("ShaderNodeOutputMaterial")
    theirs.target = "EEVEE"
    shader = nodes.new("ShaderNodeEmission")
    material.node_tree.links.new(shader.outputs[0], theirs.inputs["Surface"])
    from diffraction_shader.addon.materials import material as ours

    ours.apply(material, tmp_path / "t.exr", ours.Settings(implementation="NODES"))
    assert of_eevee(material.node_tree) == theirs
    assert theirs.inputs["Surface"].links[0].from_node == shader


def test_a_mixed_node_is_left_to_its_user(made, tmp_path):
    tree = made.node_tree
    node = tree.nodes["Diffraction"]
    tree.nodes.remove(of_eevee(tree))
    bpy.context.view_layer.update()
    mix = tree.nodes.new("ShaderNodeMixShader")
    main = tree.get_output_node("CYCLES").inputs["Surface"]
    tree.links.new(node.outputs["BSDF"], mix.inputs[1])
    tree.links.new(mix.outputs[0], main)
    from diffraction_shader.addon.materials import material as ours

    ours.apply(made, tmp_path / "t.exr", ours.Settings(implementation="NODES"))
    assert main.links[0].from_node == mix
    assert of_eevee(tree).target == "ALL"
