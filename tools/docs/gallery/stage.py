# SPDX-License-Identifier: GPL-3.0-or-later
"""What the pictures share: an empty room, lamps, a camera, plain materials, lathed and swept shapes."""

from __future__ import annotations

import math

import bpy
import numpy as np
from mathutils import Vector


def empty_room(blend, world=(0.0, 0.0, 0.0)):
    """A new file, stored so that scan and table are kept beside it, with an even world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.world = bpy.data.worlds.new("Room")
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*world, 1.0)
    blend.parent.mkdir(parents=True, exist_ok=True)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    return scene


def diffract(objects, preset, structure=None, bake=None, **surface):
    """Give objects the material of a preset, by the operators an artist uses."""
    bpy.ops.diffraction.make_preset(preset=preset, **(structure or {}))
    bpy.ops.diffraction.bake(**(bake or {}))
    for ob in bpy.context.scene.objects:
        ob.select_set(ob in objects)
    bpy.context.view_layer.objects.active = objects[0]
    bpy.ops.diffraction.apply_material(**surface)


def link(name, data):
    """A new object of the scene."""
    ob = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(ob)
    return ob


def camera(place, target, lens, blur=None):
    """The camera, looking at a point; `blur` is (distance of sharpness, f-stop)."""
    data = bpy.data.cameras.new("Camera")
    data.lens, data.clip_start = lens, 0.005
    if blur is not None:
        data.dof.use_dof, data.dof.focus_distance, data.dof.aperture_fstop = True, *blur
    ob = link("Camera", data)
    aim(ob, place, target)
    bpy.context.scene.camera = ob
    return ob


def aim(ob, place, target):
    """Put an object somewhere and let its -z look at a point."""
    ob.location = place
    ob.rotation_euler = (Vector(target) - Vector(place)).to_track_quat("-Z", "Y").to_euler()


def bulb(name, place, watts, radius, colour=(1.0, 1.0, 1.0)):
    """A small lamp."""
    light = bpy.data.lights.new(name, "POINT")
    light.energy, light.shadow_soft_size, light.color = watts, radius, colour
    ob = link(name, light)
    ob.location = place
    return ob


def softbox(name, place, target, size, watts, colour=(1.0, 1.0, 1.0)):
    """An area lamp."""
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.size_y, light.energy, light.color = "RECTANGLE", *size, watts, colour
    ob = link(name, light)
    aim(ob, place, target)
    return ob


def plain(name, colour, roughness=0.5, metallic=0.0, transmission=0.0):
    """A Principled material."""
    material = bpy.data.materials.new(name)
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*colour, 1.0)
    inputs["Roughness"].default_value = roughness
    inputs["Metallic"].default_value = metallic
    inputs["Transmission Weight"].default_value = transmission
    return material


def grid(name, points, uv, closed=False):
    """A smooth mesh of quads from ``(rows, columns, 3)`` points and ``(rows, columns, 2)`` coordinates.

    Faces look along the cross product of the directions in which columns and rows grow.
    """
    rows, columns = points.shape[:2]
    index = np.arange(rows * columns).reshape(rows, columns)
    if closed:
        index[:, -1] = index[:, 0]
    place = np.arange(rows * columns).reshape(rows, columns)

    def corners(a):
        return np.stack([a[:-1, :-1], a[:-1, 1:], a[1:, 1:], a[1:, :-1]], -1).reshape(-1, 4)

    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points.reshape(-1, 3).tolist(), [], corners(index).tolist())
    coordinates = uv.reshape(-1, 2)[corners(place).ravel()]
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", coordinates.astype(np.float32).ravel())
    mesh.shade_smooth()
    return mesh


def lathe(name, profile, segments=360):
    """A surface of revolution about z; ``profile`` is ``(n, 2)`` of radius and height.

    Faces look up where the radius shrinks along the profile.
    """
    profile = np.asarray(profile, float)
    angle = np.linspace(0.0, 2.0 * math.pi, segments + 1)
    radius, height = profile[:, 0, None], profile[:, 1, None] + 0.0 * angle
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], -1)
    uv = np.stack(np.broadcast_arrays(radius, angle[None]), -1)
    return grid(name, points, uv, closed=True)


def table_top(size, material, z=0.0):
    """A floor."""
    mesh = bpy.data.meshes.new("Table")
    mesh.from_pydata([(-size, -size, z), (size, -size, z), (size, size, z), (-size, size, z)], [], [(0, 1, 2, 3)])
    mesh.materials.append(material)
    return link("Table", mesh)
