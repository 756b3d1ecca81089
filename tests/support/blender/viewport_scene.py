# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes for the viewport: objects with one of our materials, lamps of every type."""

from pathlib import Path

import bpy
from mathutils import Matrix, Vector

from tests.support.blender import extension


def give_material(ob, path, name="material", **settings):
    """A material of ours on an object."""
    from diffraction_shader.addon.materials import material

    shaded = bpy.data.materials.new(name)
    extension.give_nodes(shaded)
    shaded.node_tree.nodes.clear()
    bpy.context.view_layer.update()
    material.apply(shaded, str(Path(path)), material.Settings(**settings))
    ob.data.materials.append(shaded)
    return shaded


def add_lamp(kind, place, aim=(0, 0, 0), power=100.0, name="lamp", scale=(1, 1, 1), **data):
    """A lamp at a place that shines at another."""
    light = bpy.data.lights.new(name, kind)
    light.energy = power
    for key, value in data.items():
        setattr(light, key, value)
    ob = bpy.data.objects.new(name, light)
    turn = (Vector(place) - Vector(aim)).to_track_quat("Z", "Y").to_matrix().to_4x4()
    ob.matrix_world = Matrix.Translation(place) @ turn @ Matrix.Diagonal((*scale, 1))
    bpy.context.scene.collection.objects.link(ob)
    return ob
