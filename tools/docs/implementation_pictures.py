# SPDX-License-Identifier: GPL-3.0-or-later
"""A ball with the snake preset by OSL, by nodes in Cycles and by nodes in EEVEE: docs/pictures/implementations.png.

`implementation_pictures.py [--out FOLDER] [--width W] [--samples N]`
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path

from tools.docs.viewport_pictures import PICTURES, ROOT, load_module, make_table, read, side_by_side

#: Implementation and engine of each picture, from left to right.
WAYS = (("OSL", "CYCLES"), ("NODES", "CYCLES"), ("NODES", "BLENDER_EEVEE"))


def make_scene():
    """A smooth ball on a grey ground under two suns and a dim sky; returns the ball."""
    import bpy
    from mathutils import Vector

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64)
    ball = bpy.context.object
    ball.data.shade_smooth()
    bpy.ops.mesh.primitive_plane_add(size=30.0, location=(0.0, 0.0, -1.0))
    ground = bpy.data.materials.new("ground")
    ground.node_tree.nodes["Principled BSDF"].inputs["Base Color"].default_value = (0.18, 0.18, 0.18, 1.0)
    bpy.context.object.data.materials.append(ground)
    for direction, colour in (((0.5, -0.6, 0.8), (1.0, 1.0, 1.0)), ((-0.9, 0.1, 0.5), (1.0, 0.9, 0.8))):
        bpy.ops.object.light_add(type="SUN")
        sun = bpy.context.object
        sun.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
        sun.data.energy, sun.data.color = 3.0, colour
    world = bpy.data.worlds.new("sky")
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.06, 0.08, 1.0)
    scene.world = world
    bpy.ops.object.camera_add()
    scene.camera = camera = bpy.context.object
    view = Vector((0.3, -1.0, 0.5)).normalized()
    camera.location, camera.rotation_euler = 7.5 * view, view.to_track_quat("Z", "Y").to_euler()
    camera.data.lens = 80.0
    scene.view_settings.view_transform = "Standard"
    scene.render.dither_intensity = 0.0
    return ball


def picture(ball, table, implementation, engine, path, width, samples):
    """Render to a PNG."""
    import bpy
    from diffraction_shader.addon.materials import material

    scene = bpy.context.scene
    ball.data.materials.clear()
    made = bpy.data.materials.new("snake")
    made.node_tree.nodes.clear()
    settings = material.Settings(implementation=implementation, ior=1.55, environment=1)
    scene.render.engine, scene.cycles.shading_system = "CYCLES", True
    bpy.context.view_layer.update()
    ball.data.materials.append(material.apply(made, str(table), settings))
    scene.render.engine = engine
    scene.cycles.samples, scene.eevee.taa_render_samples = samples, 32
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x, scene.render.resolution_y = width, round(0.8 * width)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return read(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=PICTURES)
    parser.add_argument("--width", type=int, default=270)
    parser.add_argument("--samples", type=int, default=128)
    arguments = parser.parse_args()
    load_module("diffraction_shader", ROOT / "__init__.py", [str(ROOT)]).register()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        table, ball = make_table(folder, "nodes"), make_scene()
        pictures = [
            picture(ball, table, *way, folder / f"{number}.png", arguments.width, arguments.samples)
            for number, way in enumerate(WAYS)
        ]
    side_by_side(pictures, arguments.out.resolve() / "implementations.png")
    difference = np.abs(pictures[1] - pictures[2]).mean()
    print(f"Cycles Nodes and EEVEE: mean difference of the displayed values {difference:.4f}", flush=True)
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    main()
