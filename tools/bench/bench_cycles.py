# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure Cycles: the diffracting material against a Principled BSDF, same scene, same samples, OSL on for both.

`bench_cycles.py [--samples N] [--rounds N]`

Two scenes with one sun: the sample snake and a sphere. Setting up (mesh, BVH, compiling the script) is taken out by
the difference of two renders with few and many samples. The time to equal noise scales the ratio with the variances
of the two pictures, estimated from pairs of renders with other seeds. Merged into out/bench.json under "cycles".
"""

import argparse
import os
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

WIDTH, HEIGHT = 240, 180


def render(samples, seed=0):
    """Render the current scene; returns linear pixels (height, width, 3) and seconds."""
    import bpy

    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = samples, seed
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "picture.exr")
        start = time.perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - start
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(WIDTH * HEIGHT * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels.reshape(HEIGHT, WIDTH, 4)[..., :3], seconds


def measure(samples, rounds):
    """Seconds for ``samples`` samples without the setting up, and the variance of a pixel over the mean squared."""
    few = max(samples // 8, 1)
    render(1)  # compiles, loads the table
    seconds = [render(samples)[1] - render(few)[1] for _ in range(rounds)]
    a, b = render(few, seed=1)[0], render(few, seed=2)[0]
    return float(np.median(seconds)), float(((a - b) ** 2).mean() / (2 * a.mean() * b.mean()))


def settings():
    """What both scenes share."""
    import bpy

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    scene.cycles.use_denoising = False
    scene.cycles.use_adaptive_sampling = False
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = WIDTH, HEIGHT, 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"


def snake_scene():
    """The sample scene with its first sun only."""
    import bpy

    from sample_blend import build_scene

    bodies = build_scene.build_scene(detail=0.4)
    bpy.data.objects.remove(bpy.data.objects["Window"])
    settings()
    return bodies


def sphere_scene():
    """A smooth sphere that fills the frame under one sun."""
    import bpy

    for ob in list(bpy.context.scene.objects):
        bpy.data.objects.remove(ob)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=128, ring_count=64)
    sphere = bpy.context.object
    bpy.ops.object.shade_smooth()
    bpy.ops.object.light_add(type="SUN", rotation=(0.5, 0.3, 0.0))
    bpy.context.object.data.angle = 0.009
    bpy.ops.object.camera_add(location=(0.0, 0.0, 4.0))
    camera = bpy.context.object
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.1
    bpy.context.scene.camera = camera
    settings()
    return [sphere]


def principled(bodies):
    """The scene's bodies with a Principled BSDF of a dark glossy skin."""
    import bpy

    material = bpy.data.materials.new("Principled")
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (0.02, 0.02, 0.02, 1.0)
    node.inputs["Roughness"].default_value = 0.2
    for body in bodies:
        body.data.materials.clear()
        body.data.materials.append(material)


def diffracting(bodies):
    """The scene's bodies with the add-on's material."""
    import bpy

    for body in bodies:
        body.data.materials.clear()
    for ob in bpy.context.scene.objects:
        ob.select_set(ob in bodies)
    bpy.context.view_layer.objects.active = bodies[0]
    bpy.ops.diffraction.apply_material(fresnel="DIELECTRIC", ior=1.5)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=3)
    arguments = parser.parse_args()
    import bpy

    from tests.support.blender import extension
    from tools.bench.results import merge

    packages = Path(
        bpy.utils.resource_path("LOCAL"), "python", "lib", f"python3.{sys.version_info[1]}", "site-packages"
    )
    sys.path.append(str(packages))  # oslquery, without which script nodes get no sockets
    extension.load().register()
    numbers = {"samples": arguments.samples, "size": [WIDTH, HEIGHT]}
    with tempfile.TemporaryDirectory() as folder:
        for name, build in (("snake", snake_scene), ("sphere", sphere_scene)):
            bpy.ops.wm.read_factory_settings(use_empty=True)
            bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / f"{name}.blend"))
            bpy.ops.diffraction.make_preset(preset="snake")
            bpy.ops.diffraction.bake()
            bodies = build()
            principled(bodies)
            plain, plain_noise = measure(arguments.samples, arguments.rounds)
            diffracting(bodies)
            ours, our_noise = measure(arguments.samples, arguments.rounds)
            ratio = ours / plain
            numbers[f"{name}_over_principled"] = ratio
            numbers[f"{name}_over_principled_equal_noise"] = ratio * our_noise / plain_noise if plain_noise else None
            numbers[f"{name}_seconds"] = {"principled": plain, "diffraction": ours}
            print(
                f"{name}: Principled {plain:.2f} s, diffraction {ours:.2f} s for {arguments.samples} samples: ratio"
                f" {ratio:.2f}; relative variance of a pixel {plain_noise:.2e} and {our_noise:.2e}",
                flush=True,
            )
    merge("cycles", numbers)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit


if __name__ == "__main__":
    main()
