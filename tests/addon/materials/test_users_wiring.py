# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's node tree is the user's: what stands after our node stays, whatever is done to the material."""

import bpy
import numpy as np
import pytest

from tests.support.blender import extension, scenes, tables


@pytest.fixture
def plane(blender, tmp_path):
    ob = scenes.plane_with_table(tmp_path)
    scenes.add_camera()
    return ob


def apply(ob, implementation):
    bpy.ops.diffraction.apply_material(implementation=implementation, fresnel="NONE", environment=0)
    return ob.active_material.node_tree


def mixed_after(tree):
    """A Mix Shader behind our node, half of it a glow."""
    mix, glow = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeEmission")
    mix.name = "Diffraction Mix"
    out = tree.get_output_node("CYCLES")
    tree.links.new(tree.nodes["Diffraction"].outputs["BSDF"], mix.inputs[1])
    tree.links.new(glow.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], out.inputs["Surface"])
    return mix


def bake_again(ob):
    from diffraction_shader.addon.materials import material, refresh

    path = material.table_path(ob.active_material)
    tables.make_table(path, tables.lobes, n_r=80)
    refresh.refresh(path, "{}")


def add_lamp(ob):
    scenes.add_sun((0.5, 0.1, 0.8), strength=0.0, name="dark")
    bpy.context.view_layer.update()


def apply_again(ob):
    apply(ob, "OSL" if extension_needs_osl(ob) else "NODES")


def extension_needs_osl(ob):
    extension.load()
    from diffraction_shader.addon.materials import material

    return material.needs_osl(ob.active_material)


@pytest.mark.parametrize("implementation", ["OSL", pytest.param("NODES", marks=pytest.mark.slow)])
@pytest.mark.parametrize("act", [bake_again, add_lamp, apply_again])
def test_a_mix_after_our_node_stays(plane, act, implementation):
    tree = apply(plane, implementation)
    mix = mixed_after(tree)
    before = scenes.render(16, samples=4)
    act(plane)
    assert plane.active_material.node_tree == tree
    assert tree.get_output_node("CYCLES").inputs["Surface"].links[0].from_node == mix
    assert mix.inputs[1].links[0].from_node == tree.nodes["Diffraction"]
    assert all(link.is_valid for link in tree.links)
    assert before.max() > 0.1
    np.testing.assert_allclose(scenes.render(16, samples=4).mean((0, 1)), before.mean((0, 1)), rtol=0.01)


def test_from_osl_to_nodes_and_back_links_and_keys_stay(plane):
    tree = apply(plane, "OSL")
    node = tree.nodes["Diffraction"]
    stripes = tree.nodes.new("ShaderNodeTexChecker")
    tree.links.new(stripes.outputs["Fac"], node.inputs["Brightness"])
    for name, value in (("DiffuseLimit", 0.3), ("Cone", 0.2)):
        node.inputs[name].default_value = value
    node.inputs["Rotation"].default_value = 0.5
    node.inputs["Rotation"].keyframe_insert("default_value", frame=1)
    for implementation in ("NODES", "OSL"):
        apply(plane, implementation)
        node = tree.nodes["Diffraction"]
        assert node.inputs["Brightness"].links[0].from_node == stripes
        assert [round(node.inputs[name].default_value, 3) for name in ("DiffuseLimit", "Cone")] == [0.3, 0.2]
        assert tree.animation_data is not None and tree.animation_data.action is not None
