# SPDX-License-Identifier: GPL-3.0-or-later
"""Worlds that shine evenly from everywhere."""

import bpy

from tests.support.blender import extension


def white_world(colour=(1, 1, 1, 1)):
    world = bpy.data.worlds.new("world")
    extension.give_nodes(world)
    world.node_tree.nodes["Background"].inputs["Color"].default_value = colour
    bpy.context.scene.world = world
    return world
