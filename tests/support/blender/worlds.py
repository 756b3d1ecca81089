# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds: one that shines evenly from everywhere, one with a picture."""

import bpy
import numpy as np

from tests.support.blender import extension


def white_world(colour=(1, 1, 1, 1)):
    world = bpy.data.worlds.new("world")
    extension.give_nodes(world)
    world.node_tree.nodes["Background"].inputs["Color"].default_value = colour
    bpy.context.scene.world = world
    return world


def picture(rgb):
    """An image data-block of linear colours ``(rows, cols, 3)``, row 0 at the bottom."""
    image = bpy.data.images.new("sky", rgb.shape[1], rgb.shape[0], float_buffer=True)
    image.pixels.foreach_set(np.concatenate([rgb, np.ones_like(rgb[..., :1])], -1).astype(np.float32).ravel())
    image.pack()
    return image


def picture_world(rgb):
    """A world that a picture of the sphere surrounds; its Environment Texture."""
    world = white_world()
    node = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = picture(rgb)
    world.node_tree.links.new(node.outputs[0], world.node_tree.nodes["Background"].inputs["Color"])
    return node
