# SPDX-License-Identifier: GPL-3.0-or-later
"""What the diffraction takes over from the shader below: normals and transparency, however they are wired."""

import bpy
import numpy as np
import pytest

from tests.support.blender import extension, scenes, tables


@pytest.fixture
def ball(blender, tmp_path):
    """A sphere under a sun before the camera, and the path of a table."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere = scenes.add_sphere(segments=32, rings=16)
    scenes.add_sun((0.3, 0.1, 0.9))
    scenes.add_camera()
    return sphere, tmp_path / "t.exr"


def below(name="below"):
    """A material with a Principled BSDF, its tree and that node."""
    made = bpy.data.materials.new(name)
    tree = extension.give_nodes(made)
    return made, tree, tree.nodes["Principled BSDF"]


def diffract(ball, made, implementation="OSL"):
    """Apply, as often as it is called."""
    from diffraction_shader.addon.materials import material

    sphere, path = ball
    bpy.context.view_layer.update()
    material.apply(made, path, material.Settings(implementation=implementation, fresnel="NONE", environment=0))
    sphere.data.materials.clear()
    sphere.data.materials.append(made)


def node_of(ball):
    return ball[0].active_material.node_tree.nodes["Diffraction"]


def wired(tree, principled, how):
    """Put something between a shader and the output, or in front of the shader."""
    output = tree.get_output_node("CYCLES")
    if how == "reroute":
        between = tree.nodes.new("NodeReroute")
        tree.links.new(principled.outputs[0], between.inputs[0])
        tree.links.new(between.outputs[0], output.inputs[0])
    elif how in ("mix", "add"):
        between = tree.nodes.new("ShaderNodeMixShader" if how == "mix" else "ShaderNodeAddShader")
        sockets = [s for s in between.inputs if s.type == "SHADER"]
        tree.links.new(tree.nodes.new("ShaderNodeEmission").outputs[0], sockets[0])
        tree.links.new(principled.outputs[0], sockets[1])
        tree.links.new(between.outputs[0], output.inputs[0])


@pytest.mark.parametrize("how", ["straight", "reroute", "mix", "add"])
def test_bump_is_found_however_it_is_wired(ball, how):
    made, tree, principled = below()
    bump = tree.nodes.new("ShaderNodeBump")
    tree.links.new(bump.outputs[0], principled.inputs["Normal"])
    wired(tree, principled, how)
    diffract(ball, made)
    (link,) = node_of(ball).inputs["Normal"].links
    assert link.from_node.bl_idname == "ShaderNodeBump"


def in_a_group(tree, inputs):
    """The tree's shader replaced by a group that holds one; returns the group's node and the shader inside."""
    group = bpy.data.node_groups.new("Skin", "ShaderNodeTree")
    for name, kind in inputs.items():
        group.interface.new_socket(name, in_out="INPUT", socket_type=kind)
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    given, out = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    inner = group.nodes.new("ShaderNodeBsdfPrincipled")
    for name in inputs:
        group.links.new(given.outputs[name], inner.inputs[name])
    group.links.new(inner.outputs[0], out.inputs[0])
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], tree.get_output_node("CYCLES").inputs[0])
    return node, inner


def test_bump_is_found_through_a_group(ball):
    made, tree, _ = below()
    node, _ = in_a_group(tree, {"Normal": "NodeSocketVector"})
    tree.links.new(tree.nodes.new("ShaderNodeBump").outputs[0], node.inputs["Normal"])
    diffract(ball, made)
    (link,) = node_of(ball).inputs["Normal"].links
    assert link.from_node.bl_idname == "ShaderNodeBump"


def set_alpha(tree, principled, kind):
    """Three ways to be 30 % opaque."""
    if kind == "value":
        principled.inputs["Alpha"].default_value = 0.3
    elif kind == "linked":
        value = tree.nodes.new("ShaderNodeValue")
        value.outputs[0].default_value = 0.3
        tree.links.new(value.outputs[0], principled.inputs["Alpha"])
    elif kind == "mixed":
        value, mix = tree.nodes.new("ShaderNodeValue"), tree.nodes.new("ShaderNodeMixShader")
        value.outputs[0].default_value = 0.3
        tree.links.new(value.outputs[0], mix.inputs[0])
        tree.links.new(tree.nodes.new("ShaderNodeBsdfTransparent").outputs[0], mix.inputs[1])
        tree.links.new(principled.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], tree.get_output_node("CYCLES").inputs[0])
    elif kind == "group":
        node, _ = in_a_group(tree, {"Alpha": "NodeSocketFloat"})
        node.inputs["Alpha"].default_value = 0.3


def black(principled):
    principled.inputs["Base Color"].default_value = (0, 0, 0, 1)
    principled.inputs["Specular IOR Level"].default_value = 0.0


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
@pytest.mark.parametrize("kind", ["value", "linked", "mixed", "group"])
def test_diffraction_is_as_opaque_as_its_pigment(ball, kind, implementation):
    """Over black at 30 % there is 30 % of the light."""
    if kind == "group" and implementation == "NODES":
        pytest.skip("the wiring does not depend on the implementation")
    made, _, principled = below()
    black(principled)
    diffract(ball, made, implementation=implementation)
    whole = scenes.render(24)
    made, tree, principled = below("thin")
    black(principled)
    set_alpha(tree, principled, kind)
    diffract(ball, made, implementation=implementation)
    thin = scenes.render(24)
    assert whole.max() > 0.1
    np.testing.assert_allclose(thin, 0.3 * whole, atol=0.02 * whole.max())


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_nothing_diffracts_where_nothing_is(ball, implementation):
    made, _, principled = below()
    principled.inputs["Alpha"].default_value = 0.0
    diffract(ball, made, implementation=implementation)
    assert scenes.render(24).max() == 0.0


def test_a_mask_of_the_users_stays(ball):
    """Apply takes the pigment's alpha only where nothing else says what the mask is."""
    made, tree, principled = below()
    principled.inputs["Alpha"].default_value = 0.5
    diffract(ball, made)
    tree = ball[0].active_material.node_tree
    stripes = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(stripes.outputs["Fac"], node_of(ball).inputs["Mask"])
    diffract(ball, made)
    assert node_of(ball).inputs["Mask"].links[0].from_node == stripes


def test_nodes_of_the_users_stay(ball):
    """Whatever they are called: only what was made here goes."""
    made, tree, principled = below()
    tint = tree.nodes.new("ShaderNodeEmission")
    tint.name = "Diffraction Tint"
    set_alpha(tree, principled, "mixed")
    diffract(ball, made)
    diffract(ball, made)
    tree = ball[0].active_material.node_tree
    assert "Diffraction Tint" in tree.nodes
    assert sum(node.name.startswith("Diffraction Alpha") for node in tree.nodes) == 1  # not one more an Apply
