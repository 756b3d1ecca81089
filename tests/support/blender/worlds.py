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


def spotted_sky(rows=64, cols=128):
    """Scene-linear RGB of a sky with soft colours and two bright spots."""
    y, x = np.mgrid[0:rows, 0:cols]
    lat, lon = (y / rows - 0.5) * np.pi, x / cols * 2 * np.pi
    rgb = np.stack([0.3 + 0.3 * np.sin(lon), 0.3 + 0.2 * np.sin(lat), 0.4 - 0.2 * np.cos(lon)], -1)
    rgb[40:46, 30:38] += 8.0
    rgb[20:23, 80:86, 0] += 15.0
    return rgb.astype(np.float32)
