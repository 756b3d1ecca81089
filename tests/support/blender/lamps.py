# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps of every type and size that look at the origin."""

import bpy
from mathutils import Vector


def add_lamp(kind, location=(0.6, -0.4, 1.6), energy=50.0, name="lamp", **data):
    """A lamp that looks at the origin; its data's properties by name."""
    light = bpy.data.lights.new(name, kind)
    light.energy = energy
    for key, value in data.items():
        setattr(light, key, value)
    ob = bpy.data.objects.new(name, light)
    ob.location = location
    ob.rotation_euler = Vector(location).to_track_quat("Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(ob)
    return ob


#: By what a person would call them: Blender's type, and what `add_lamp` takes.
LAMPS = {
    "sun": ("SUN", {"angle": 0.0, "energy": 3.0}),
    "wide sun": ("SUN", {"angle": 0.6, "energy": 3.0}),
    "point": ("POINT", {"shadow_soft_size": 0.0}),
    "ball": ("POINT", {"shadow_soft_size": 0.4}),
    "disc-shaped ball": ("POINT", {"shadow_soft_size": 0.3, "use_soft_falloff": False}),
    "spot": ("SPOT", {"shadow_soft_size": 0.05, "spot_size": 0.9, "spot_blend": 0.3, "energy": 150.0}),
    "small area": ("AREA", {"shape": "SQUARE", "size": 0.05}),
    "square": ("AREA", {"shape": "SQUARE", "size": 0.8}),
    "rectangle": ("AREA", {"shape": "RECTANGLE", "size": 0.3, "size_y": 2.0}),
    "disk": ("AREA", {"shape": "DISK", "size": 1.0}),
    "ellipse": ("AREA", {"shape": "ELLIPSE", "size": 1.6, "size_y": 0.5, "spread": 2.0}),
}
