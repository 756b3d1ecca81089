# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs in the second Blender of `panorama`, as a program of its own: renders a world all around, without its suns.

Arguments: the .blend that holds the world, the file of numbers to write, width in pixels, name of the working space,
and suns as ``x,y,z,radius`` each. What is rendered is the world as rays see it that leave a surface by a glossy lobe.
"""

import os
import sys
import tempfile
from typing import Any

import bpy
import numpy as np

#: What a node *Light Path* says to such rays; all else is 0.
_LIGHT_PATH = {"Is Glossy Ray": 1.0, "Is Reflection Ray": 1.0, "Ray Depth": 1.0, "Glossy Depth": 1.0, "Ray Length": 1e5}

#: Samples a pixel, and pixels along a picture of a sun.
_SAMPLES, _SUN_SIDE = 16, 64


def main(blend: str, out: str, width: int, space: str, suns: list[tuple[float, ...]]) -> None:
    """Render, and write ``pixels`` (rows, cols, 3) and ``suns`` (n, 7: direction, irradiance, radius)."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    colorspace = getattr(bpy.data, "colorspace", None)
    if colorspace is not None and space and colorspace.working_space != space:
        bpy.ops.wm.set_working_color_space(working_space=space)
    libraries: Any = bpy.data.libraries
    with libraries.load(blend) as (there, wanted):
        wanted.worlds = there.worlds[:1]
    world = wanted.worlds[0]
    scene: Any = bpy.context.scene
    scene.world = world
    visibility = getattr(world, "cycles_visibility", None)
    seen = visibility is None or visibility.glossy
    if visibility is not None:
        visibility.camera = True
    skies = _prepare(world)
    _settings(scene, world)
    camera = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    _show_suns(skies, False)
    pixels = _panorama(scene, camera, width)
    without = [_narrow(scene, camera, sun) for sun in suns]
    _show_suns(skies, True)
    found = [
        (*sun[:3], *np.maximum(_narrow(scene, camera, sun) - dark, 0.0), sun[3])
        for sun, dark in zip(suns, without, strict=True)
    ]
    if not seen:
        pixels, found = np.zeros_like(pixels), []
    np.savez(out, pixels=pixels, suns=np.array(found, np.float32).reshape(-1, 7))


def _prepare(world: Any) -> list[Any]:
    """Answer for the light path, drop volumes; the skies that show a sun."""
    if world.node_tree is None:
        return []
    skies = []
    for tree in [world.node_tree, *(group for group in bpy.data.node_groups if group.bl_idname == "ShaderNodeTree")]:
        for node in list(tree.nodes):
            if node.bl_idname == "ShaderNodeLightPath":
                _answer(tree, node)
            elif node.bl_idname == "ShaderNodeOutputWorld":
                for link in list(node.inputs["Volume"].links):
                    tree.links.remove(link)
            elif node.bl_idname == "ShaderNodeTexSky" and getattr(node, "sun_disc", False):
                skies.append(node)
    return skies


def _answer(tree: Any, node: Any) -> None:
    for output in node.outputs:
        targets = [link.to_socket for link in output.links]
        if targets:
            value = tree.nodes.new("ShaderNodeValue")
            value.outputs[0].default_value = _LIGHT_PATH.get(output.name, 0.0)
            for target in targets:
                tree.links.new(value.outputs[0], target)


def _settings(scene: Any, world: Any) -> None:
    scene.render.engine = "CYCLES"
    scene.render.resolution_percentage = 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.cycles.device, scene.cycles.samples = "CPU", _SAMPLES
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.pixel_filter_type, scene.cycles.sample_clamp_direct = "BOX", 0.0
    scene.cycles.max_bounces = 0
    scene.cycles.shading_system = any(
        node.bl_idname == "ShaderNodeScript"
        for tree in [world.node_tree, *bpy.data.node_groups]
        if tree is not None
        for node in tree.nodes
    )
    world.cycles.sampling_method = "NONE"  # nothing is lit here


def _show_suns(skies: list[Any], shown: bool) -> None:
    for sky in skies:
        sky.sun_disc = shown


def _panorama(scene: Any, camera: Any, width: int) -> np.ndarray:
    lens = camera.data
    lens.type = "PANO"
    owner = lens if hasattr(lens, "panorama_type") else lens.cycles  # 4.5 keeps it with Cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    # The middle of a picture of the sphere is +x, its upper edge +z.
    camera.rotation_euler = (0.5 * np.pi, 0.0, -0.5 * np.pi)
    return _render(scene, width, width // 2)


def _narrow(scene: Any, camera: Any, sun: tuple[float, ...]) -> np.ndarray:
    """Irradiance ``(3,)`` of a small square about a direction, on a surface that faces it."""
    from mathutils import Vector

    lens = camera.data
    lens.type, lens.sensor_fit = "PERSP", "HORIZONTAL"
    half = 1.25 * sun[3] + 0.001
    lens.angle = 2.0 * half
    camera.rotation_euler = Vector(sun[:3]).to_track_quat("-Z", "Y").to_euler()
    pixels = _render(scene, _SUN_SIDE, _SUN_SIDE)
    along = ((np.arange(_SUN_SIDE) + 0.5) / _SUN_SIDE * 2.0 - 1.0) * np.tan(half)
    x, y = np.meshgrid(along, along)
    return (pixels * (1.0 + x**2 + y**2)[..., None] ** -2.0).sum((0, 1)) * (2.0 * np.tan(half) / _SUN_SIDE) ** 2


def _render(scene: Any, width: int, height: int) -> np.ndarray:
    scene.render.resolution_x, scene.render.resolution_y = width, height
    folder = tempfile.mkdtemp()
    scene.render.filepath = os.path.join(folder, "world.exr")
    try:
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.is_data = True
        values = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(values)
        bpy.data.images.remove(image)
    finally:
        if os.path.exists(scene.render.filepath):
            os.remove(scene.render.filepath)
        os.rmdir(folder)
    rgb = values.reshape(height, width, -1)[..., :3]
    return np.nan_to_num(rgb, nan=0.0, posinf=6e4, neginf=0.0)


if __name__ == "__main__":
    words = sys.argv[sys.argv.index("--") + 1 :]
    main(words[0], words[1], int(words[2]), words[3], [tuple(map(float, word.split(","))) for word in words[4:]])
