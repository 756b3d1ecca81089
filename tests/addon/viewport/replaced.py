# SPDX-License-Identifier: GPL-3.0-or-later
"""What `test_masks.py` runs in a process of its own: masks and alpha where the surface is drawn anew."""

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, extension, scenes, tables
from tests.support.blender.masked import node_of, share, stripes


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
