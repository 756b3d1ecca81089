# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene's light list says, read from its custom properties by their documented names."""

import bpy


def kinds(scene=None, count=4):
    """Kinds of the first slots, after the handlers had their turn."""
    scene = scene or bpy.context.scene
    bpy.context.view_layer.update()
    bpy.context.view_layer.update()
    return [round(scene[f"diffraction_lamp_{slot:02d}"][3]) for slot in range(1, count + 1)]


def place(slot, scene=None):
    """Place of a lamp, or direction to a sun."""
    bpy.context.view_layer.update()
    return tuple((scene or bpy.context.scene)[f"diffraction_lamp_{slot:02d}"])[:3]
