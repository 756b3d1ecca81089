# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a material diffracts in the viewport: its mask and the alpha of its pigment; the mirror of a lacquer's face."""

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, extension, scenes, tables
from tests.support.blender import viewport_scene as scene
from tests.support.blender.worlds import picture


@pytest.fixture
def plane(renderer, tmp_path):
    """A diffracting plane of 2 x 2 m under a sun, seen from above; its material."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    ob = scenes.add_plane(half=1.0)
    scenes.add_sun((0.3, 0.2, 1.0), strength=2.0)
    scenes.add_camera((0.1, 0.2, 1.0), extent=2.0)
    return scene.give_material(ob, tmp_path / "t.exr", fresnel="NONE")


def node_of(shaded):
    from diffraction_shader.addon.materials import material

    return material.shader_node(shaded)


def stripes(tree):
    """An Image Texture of a quarter, whose left half is 0 and right half 1, in colour and alpha alike."""
    rgb = np.zeros((32, 32, 3))
    rgb[:, 16:] = 1.0
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = picture(rgb)
    values = np.concatenate([rgb, rgb[..., :1]], -1).astype(np.float32)
    node.image.pixels.foreach_set(values.ravel())
    node.image.update()
    return node


def test_a_number(renderer, plane):
    whole = drawing.alone(renderer, 32)
    node_of(plane).inputs["Mask"].default_value = 0.25
    assert whole.max() > 0.1
    assert drawing.alone(renderer, 32) == pytest.approx(0.25 * whole, rel=1e-5, abs=1e-7)


def share(found, whole):
    """What is left of each pixel that shone, red."""
    return (found / np.maximum(whole, 1e-9))[..., 0][whole[..., 0] > 0.01]


@pytest.mark.parametrize("output", ["Color", "Alpha"])
def test_an_image(renderer, plane, output):
    """Half of the plane; taken from 1, the other half."""
    whole = drawing.alone(renderer, 32)
    node = node_of(plane)
    tree = node.id_data
    image = stripes(tree)
    tree.links.new(image.outputs[output], node.inputs["Mask"])
    found = drawing.alone(renderer, 32)
    left = share(found, whole)
    assert 0.4 < (left < 1e-6).mean() < 0.55
    assert 0.4 < (np.abs(left - 1.0) < 1e-4).mean() < 0.55
    turned = tree.nodes.new("ShaderNodeMath")
    turned.operation = "SUBTRACT"
    turned.inputs[0].default_value = 1.0
    tree.links.new(image.outputs[output], turned.inputs[1])
    tree.links.new(turned.outputs[0], node.inputs["Mask"])
    assert drawing.alone(renderer, 32) + found == pytest.approx(whole, rel=1e-4, abs=1e-6)


def test_more_than_one_image_is_left_out(blender, plane):
    from diffraction_shader.addon.viewport.data import masks

    node = node_of(plane)
    tree = node.id_data
    a, b = stripes(tree), stripes(tree)
    b.image = picture(np.ones((4, 4, 3)))
    product = tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    tree.links.new(a.outputs[0], product.inputs[0])
    tree.links.new(b.outputs[0], product.inputs[1])
    tree.links.new(product.outputs[0], node.inputs["Mask"])
    assert masks.of(plane) == masks.Mask()
    product.inputs[1].default_value = 0.5
    tree.links.remove(product.inputs[1].links[0])
    assert masks.of(plane) == masks.Mask(0.0, 0.5, a.image)


def test_a_transparent_pigment_is_cut_out(renderer, blender, tmp_path):
    """Replace: where the pigment's alpha is 0 nothing is drawn; elsewhere all is as without the alpha."""
    from diffraction_shader.addon.materials import material

    tables.make_table(tmp_path / "t.exr", tables.lobes)
    ob = scenes.add_plane(half=1.0)
    scenes.add_sun((0.3, 0.2, 1.0), strength=2.0)
    scenes.add_camera((0.1, 0.2, 1.0), extent=2.0)
    shaded = bpy.data.materials.new("card")
    extension.give_nodes(shaded)
    ob.data.materials.append(shaded)
    shader = shaded.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (0.3, 0.2, 0.1, 1.0)
    image = stripes(shaded.node_tree)
    material.apply(shaded, str(tmp_path / "t.exr"), material.Settings(fresnel="DIELECTRIC"))
    whole = drawing.alone(renderer, 32, surface="REPLACE")
    shaded.node_tree.links.new(image.outputs["Alpha"], shader.inputs["Alpha"])
    material.apply(shaded, str(tmp_path / "t.exr"), material.Settings(fresnel="DIELECTRIC"))
    found = drawing.alone(renderer, 32, surface="REPLACE")
    left = share(found, whole)
    assert 0.4 < (left == 0.0).mean() < 0.6
    assert (np.abs(left - 1.0) < 1e-3).mean() == pytest.approx(1.0 - (left == 0.0).mean(), abs=0.06)


def test_no_light_is_lost_where_nothing_diffracts(renderer, plane, tmp_path):
    """Replace with a mask of 0: the pigment, all of it."""
    node = node_of(plane)
    tree = node.id_data
    base = tree.nodes.new("ShaderNodeBsdfDiffuse")
    base.inputs["Color"].default_value = (0.4, 0.3, 0.2, 1.0)
    tree.links.new(base.outputs[0], node.inputs["Base"])
    node.inputs["Mask"].default_value = 0.0
    found = drawing.alone(renderer, 32, surface="REPLACE")[16, 16]
    cosine = 1.0 / np.linalg.norm((0.3, 0.2, 1.0))
    assert found == pytest.approx(np.array([0.4, 0.3, 0.2]) * 2.0 * cosine / np.pi, rel=1e-3)
