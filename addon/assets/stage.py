# SPDX-License-Identifier: GPL-3.0-or-later
"""The stage on which materials are pictured: a ball under two suns, a disc under a bulb, a dim sky."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from ..versions import give_nodes

#: Side of the pictures in pixels.
SIDE = 128

#: Suns of the ball: direction, and irradiance on skin. Metal reflects twenty times as much.
_SUNS = {"Sun": ((-0.35, -0.55, 0.75), 22.0), "Window": ((0.75, -0.3, 0.45), 9.0)}


def build(scene: bpy.types.Scene) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball under two suns and a disc under a bulb near the camera, where a disc shows its spokes, and a dim sky."""
    ball = _link(scene, "Ball", _ball())
    disc = _link(scene, "Disc", _disc())
    disc.rotation_euler = (math.radians(62.0), 0.0, math.radians(12.0))
    for name, (direction, _) in _SUNS.items():
        light = bpy.data.lights.new(name, "SUN")
        light.angle = math.radians(1.0)
        lamp = _link(scene, name, light)
        lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
    bulb = bpy.data.lights.new("Bulb", "POINT")
    bulb.energy, bulb.shadow_soft_size = 200.0, 0.04
    _link(scene, "Bulb", bulb).location = (0.35, -2.9, 1.2)
    camera = bpy.data.cameras.new("Camera")
    camera.lens = 36.0 * 3.6 / 2.25
    scene.camera = _link(scene, "Camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -3.6, 0.0), (math.radians(90.0), 0.0, 0.0)
    world = bpy.data.worlds.new("Dim Sky")
    give_nodes(world)
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.06, 0.08, 1.0)
    scene.world = world
    scene.view_settings.view_transform = "Standard"
    bpy.context.view_layer.update()
    return ball, disc


def _ball(segments: int = 128, rings: int = 64) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Ball")
    lon = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    lat = np.linspace(-0.5 * np.pi + 0.02, 0.5 * np.pi - 0.02, rings + 1)
    lon, lat = np.meshgrid(lon, lat)  # type: ignore[assignment]
    points = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1).reshape(-1, 3)
    return _grid(mesh, points, np.stack([lon, lat], -1).reshape(-1, 2), segments + 1, rings + 1)


def _disc(segments: int = 192, rings: int = 4) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Disc")
    # From the rim inwards, so that the faces look up.
    lon, radius = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, segments + 1), np.linspace(1.0, 0.2, rings + 1))
    points = np.stack([radius * np.cos(lon), radius * np.sin(lon), np.zeros_like(lon)], -1).reshape(-1, 3)
    return _grid(mesh, points, np.stack([radius, lon], -1).reshape(-1, 2), segments + 1, rings + 1)


def _grid(mesh: bpy.types.Mesh, points: np.ndarray, uv: np.ndarray, columns: int, rows: int) -> bpy.types.Mesh:
    index = np.arange(columns * rows).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", uv[quads.ravel()].astype(np.float32).ravel())
    mesh.shade_smooth()
    return mesh


def picture(
    scene: bpy.types.Scene,
    material: bpy.types.Material,
    objects: tuple[bpy.types.Object, bpy.types.Object],
    flat: bool,
    metal: bool,
    samples: int,
) -> np.ndarray:
    """Render a material on its object.

    Parameters
    ----------
    scene
        That of `build`.
    material
        On one of the objects.
    objects
        Those of `build`.
    flat
        Whether it is a disc, whose spokes a bulb near the camera shows.
    metal
        Whether it reflects like metal, twenty times as much as skin.
    samples
        A pixel.

    Returns
    -------
    array
        ``(SIDE * SIDE * 4,)`` RGBA as a display shows it, transparent beside the object, bottom row first.
    """
    for ob in objects:
        ob.hide_render = ob.active_material != material
    for name, (_, strength) in _SUNS.items():
        scene.objects[name].hide_render = flat
        scene.objects[name].data.energy = strength * (0.06 if metal else 1.0)
    scene.objects["Bulb"].hide_render = not flat
    bpy.context.view_layer.update()
    render = scene.render
    render.resolution_x = render.resolution_y = SIDE
    render.resolution_percentage = 100
    render.film_transparent = True
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGBA"
    scene.cycles.samples = samples
    with tempfile.TemporaryDirectory() as folder:
        render.filepath = str(Path(folder) / "preview.png")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath)
        pixels = np.empty(SIDE * SIDE * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels


def _link(scene: bpy.types.Scene, name: str, data: bpy.types.ID) -> bpy.types.Object:
    ob = bpy.data.objects.new(name, data)
    scene.collection.objects.link(ob)
    return ob
