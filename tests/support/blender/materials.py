# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials for tests: ours without the operators, ours with a BRDF of constant value, and Blender's diffuse one."""

import bpy

from tests.support.blender import extension


def diffracting(ob, table_path, implementation="OSL", pigment=(0, 0, 0, 1), **settings):
    """Give an object a material of ours that follows the scene's lamps, and return it."""
    extension.load()
    from diffraction_shader.addon.materials import material

    bpy.context.view_layer.update()
    made = bpy.data.materials.new(ob.name)
    extension.give_nodes(made)
    made.node_tree.nodes.clear()
    material.apply(
        made,
        table_path,
        material.Settings(implementation=implementation, **settings),
    )
    made.node_tree.nodes["Pigment"].inputs["Color"].default_value = pigment
    ob.data.materials.clear()
    ob.data.materials.append(made)
    return made


def lambertian(monkeypatch):
    """Replace the table's lookup in the OSL source by f = 1 / pi: then a diffuse closure gives the same picture."""
    extension.load()
    from diffraction_shader.addon.materials import osl

    source = osl.source
    lookup = (
        "color xyz = (factor * scale * scale)\n"
        "                * table_transform(atlas, -scale * (wi[0] + wr[0]), -scale * (wi[1] + wr[1]), depth * w_abs);"
    )

    def constant(layout, albedo_max, **options):
        text = source(layout, albedo_max, **options)
        assert lookup in text
        return text.replace(lookup, "color xyz = color(0.95047, 1.0, 1.08883) * (wi[2] / M_PI);")

    monkeypatch.setattr(osl, "source", constant)


def white_diffuse(ob):
    """Give an object a diffuse material of albedo 1."""
    made = bpy.data.materials.new("white")
    extension.give_nodes(made)
    nodes = made.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (1, 1, 1, 1)
    made.node_tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    ob.data.materials.clear()
    ob.data.materials.append(made)
    return made
