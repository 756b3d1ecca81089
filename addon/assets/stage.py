# SPDX-License-Identifier: GPL-3.0-or-later
"""The stage on which materials are pictured: a ball under two suns, a disc and a card under a bulb, a sky.

What mirrors shows its surroundings more than its colours: the sky is dimmed for it, and a tube beside the camera, whose
orders stand beside its mirror image as upright stripes, shows which way each colour goes.
"""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ..versions import give_nodes
from .looks import Asset

#: Side of the pictures in pixels.
SIDE = 128

#: Suns of the ball: direction, and irradiance on skin. Metal reflects twenty times as much.
_SUNS = {"Sun": ((-0.35, -0.55, 0.75), 22.0), "Window": ((0.75, -0.3, 0.45), 9.0)}

#: Power of the tube.
_TUBE = 90.0


def build(scene: bpy.types.Scene) -> dict[str, bpy.types.Object]:
    """A ball under two suns and beside a tube, a disc and cards under a bulb near the camera, where a disc shows its
    spokes, and a sky; all by the names that `picture` knows. Four lamps: EEVEE's share of the scene's list."""
    shapes = {name: _link(scene, name.title(), make()) for name, make in _SHAPES.items()}
    shapes["DISC"].rotation_euler = (math.radians(62.0), 0.0, math.radians(12.0))
    for name in ("CARD", "PLATE"):
        shapes[name].rotation_euler = (math.radians(76.0), 0.0, math.radians(8.0))
    for name, (direction, _) in _SUNS.items():
        light = bpy.data.lights.new(name, "SUN")
        light.angle = math.radians(1.0)
        lamp = _link(scene, name, light)
        lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
    bulb = bpy.data.lights.new("Bulb", "POINT")
    bulb.energy, bulb.shadow_soft_size = 200.0, 0.04
    _link(scene, "Bulb", bulb).location = (0.35, -2.9, 1.2)
    tube = bpy.data.lights.new("Tube", "AREA")
    tube.shape, tube.size, tube.size_y, tube.energy = "RECTANGLE", 0.14, 3.2, _TUBE
    lamp = _link(scene, "Tube", tube)
    lamp.location = (-3.5, -3.7, 0.3)
    lamp.rotation_euler = Vector((3.5, 3.7, 0.0)).to_track_quat("-Z", "Y").to_euler()
    camera = bpy.data.cameras.new("Camera")
    camera.lens = 36.0 * 3.6 / 2.25
    scene.camera = _link(scene, "Camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -3.6, 0.0), (math.radians(90.0), 0.0, 0.0)
    scene.world = _sky()
    scene.view_settings.view_transform = "Standard"
    bpy.context.view_layer.update()
    return shapes


def _sky() -> bpy.types.World:
    """A room that is dark below and bright above, for what mirrors it."""
    world = bpy.data.worlds.new("Sky")
    tree = give_nodes(world)
    place, up, ramp = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    tree.links.new(place.outputs["Generated"], up.inputs[0])
    tree.links.new(up.outputs["Z"], ramp.inputs[0])
    tree.links.new(ramp.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    colours = ramp.color_ramp
    for each, at, colour in zip(
        (colours.elements[0], colours.elements[1], *(colours.elements.new(0.5) for _ in range(2))),
        (0.0, 1.0, 0.15, 0.55),
        ((0.030, 0.030, 0.032), (0.40, 0.43, 0.48), (0.06, 0.065, 0.075), (0.24, 0.26, 0.30)),
        strict=True,
    ):
        each.position, each.color = at, (*colour, 1.0)
    return world


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
    lon, radius = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, segments + 1), np.linspace(1.0, 0.125, rings + 1))
    points = np.stack([radius * np.cos(lon), radius * np.sin(lon), np.zeros_like(lon)], -1).reshape(-1, 3)
    return _grid(mesh, points, np.stack([radius, lon], -1).reshape(-1, 2), segments + 1, rings + 1)


def _card(width: float = 1.40, columns: int = 64, rows: int = 4) -> bpy.types.Mesh:
    """A playing card, bent a little, so that its colours change across."""
    mesh = bpy.data.meshes.new("Card")
    u, v = np.meshgrid(np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, 1.0, rows + 1))
    turn, radius = (u - 0.5) * 0.35, width / 0.35
    points = np.stack([radius * np.sin(turn), 1.96 * (v - 0.5), radius * (np.cos(turn) - 1.0)], -1).reshape(-1, 3)
    return _grid(mesh, points, np.stack([u, v], -1).reshape(-1, 2), columns + 1, rows + 1)


def _body(rings: int = 160, around: int = 96) -> bpy.types.Mesh:
    """Part of a snake that winds along x."""
    mesh = bpy.data.meshes.new("Body")
    x = np.linspace(-1.02, 1.02, rings + 1)
    rise, bend = 0.30 * np.sin(3.2 * x), 0.96 * np.cos(3.2 * x)
    turn = np.linspace(2.0 * np.pi, 0.0, around + 1)
    norm = np.hypot(1.0, bend)
    out = np.stack([-bend / norm, np.zeros_like(x), 1.0 / norm], -1)
    ring = np.cos(turn)[None, :, None] * np.array([0.0, -1.0, 0.0]) + np.sin(turn)[None, :, None] * out[:, None]
    points = np.stack([x, np.zeros_like(x), rise], -1)[:, None] + 0.36 * ring
    uv = np.stack(np.broadcast_arrays(np.linspace(0.0, 1.0, rings + 1)[:, None], turn[None] / (2.0 * np.pi)), -1)
    return _grid(mesh, points.reshape(-1, 3), uv.reshape(-1, 2), around + 1, rings + 1)


_SHAPES: dict[str, Callable[[], bpy.types.Mesh]] = {
    "BALL": _ball,
    "DISC": _disc,
    "CARD": _card,
    "PLATE": lambda: _card(1.96),
    "BODY": _body,
}


def _grid(mesh: bpy.types.Mesh, points: np.ndarray, uv: np.ndarray, columns: int, rows: int) -> bpy.types.Mesh:
    index = np.arange(columns * rows).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", uv[quads.ravel()].astype(np.float32).ravel())
    mesh.shade_smooth()
    return mesh


def picture(
    scene: bpy.types.Scene, shapes: dict[str, bpy.types.Object], asset: Asset, samples: int, side: int = SIDE
) -> np.ndarray:
    """Render the shape of an asset, which has its material.

    Parameters
    ----------
    scene
        That of `build`.
    shapes
        Those of `build`.
    asset
        Which shape is shown, and how it is exposed; discs and cards show their colours under the bulb.
    samples
        A pixel.
    side
        Of the picture, pixels.

    Returns
    -------
    array
        ``(side * side * 4,)`` RGBA as a display shows it, transparent beside the object, bottom row first.
    """
    for name, ob in shapes.items():
        ob.hide_render = name != asset.shape
    flat = asset.shape not in ("BALL", "BODY")
    for name, (_, strength) in _SUNS.items():
        scene.objects[name].hide_render = flat
        scene.objects[name].data.energy = strength / asset.bright
    scene.objects["Bulb"].hide_render = not flat
    scene.objects["Tube"].data.energy = _TUBE / asset.dim
    scene.objects["Tube"].hide_render = asset.shape in ("BODY", "DISC") or not asset.mirrors
    assert scene.world is not None
    sky: Any = give_nodes(scene.world).nodes["Background"]
    sky.inputs["Strength"].default_value = asset.sky
    bpy.context.view_layer.update()
    render = scene.render
    render.resolution_x = render.resolution_y = side
    render.resolution_percentage = 100
    render.film_transparent = True
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGBA"
    scene.cycles.samples = samples
    with tempfile.TemporaryDirectory() as folder:
        render.filepath = str(Path(folder) / "preview.png")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath)
        pixels = np.empty(side * side * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels


def _link(scene: bpy.types.Scene, name: str, data: bpy.types.ID) -> bpy.types.Object:
    ob = bpy.data.objects.new(name, data)
    scene.collection.objects.link(ob)
    return ob
