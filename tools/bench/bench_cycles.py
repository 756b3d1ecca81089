# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure Cycles: the diffracting material against a Principled BSDF, same scene, same samples, OSL on for both.

`bench_cycles.py [--samples N] [--rounds N]`

Two scenes with one sun and the material's environment at 1, the sample snake and a sphere. Materials render in turn;
setting up (mesh, BVH, compiling the script) is taken out by the difference of two renders with few and many samples.

Noise is the variance of a pixel over its squared mean, from renders with other seeds, and the *median* over the lit
pixels: the mean is decided by the few pixels that hold a mirror-like peak narrower than themselves, and says how many
peaks a seed hit. What part of the whole variance the noisiest hundredth of the pixels has is told beside it. The time
to equal noise scales the ratio of times by the ratio of the medians. Merged into out/bench.json under "cycles".
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

#: Renders with other seeds that the noise is taken from, and the part of the brightest pixel from which one is lit.
SEEDS, LIT = 6, 1e-3


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


def few(samples):
    """Samples of the short render."""
    return max(samples // 8, 1)


def seconds(samples):
    """Seconds for samples without the setting up."""
    return render(samples)[1] - render(few(samples))[1]


def noise(samples):
    """Relative variance of a pixel with few samples: its median, and the share of the noisiest hundredth of them."""
    pictures = np.stack([render(few(samples), seed=seed)[0].sum(-1) for seed in range(1, 1 + SEEDS)]).astype(float)
    mean, variance = pictures.mean(0), pictures.var(0, ddof=1)
    lit = mean > LIT * mean.max()
    noisiest = np.sort(variance.ravel())[-max(variance.size // 100, 1) :]
    return float(np.median(variance[lit] / mean[lit] ** 2)), float(noisiest.sum() / max(variance.sum(), 1e-300))


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


def principled():
    """A Principled BSDF of a dark glossy skin."""
    import bpy

    material = bpy.data.materials.new("Principled")
    material.use_nodes = True
    node = material.node_tree.nodes["Principled BSDF"]
    node.inputs["Base Color"].default_value = (0.02, 0.02, 0.02, 1.0)
    node.inputs["Roughness"].default_value = 0.2
    return material


def diffracting(bodies):
    """The add-on's material in OSL, which lies on the bodies afterwards."""
    import bpy

    for ob in bpy.context.scene.objects:
        ob.select_set(ob in bodies)
    bpy.context.view_layer.objects.active = bodies[0]
    bpy.ops.diffraction.apply_material(implementation="OSL", fresnel="DIELECTRIC", ior=1.5, environment=1)
    return bodies[0].active_material


def measure(bodies, materials, samples, rounds):
    """Seconds a round and noise of each material, in turn.

    Returns
    -------
    dict
        Name -> list of seconds.
    dict
        Name -> (median relative variance, share of the noisiest hundredth of the pixels).
    """
    taken = {name: [] for name in materials}
    noises = {}
    for number in range(rounds):
        for name, material in materials.items():
            for body in bodies:
                body.data.materials.clear()
                body.data.materials.append(material)
            if number == 0:
                noises[name] = noise(samples)  # compiles the script and loads the table, too
            taken[name].append(seconds(samples))
    return taken, noises


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    arguments = parser.parse_args()
    import bpy

    from tests.support.blender import extension
    from tools.bench.machine import Spread, warn_if_busy
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
            for body in bodies:
                body.data.materials.clear()
            materials = {"diffraction": diffracting(bodies), "principled": principled()}
            taken, noises = measure(bodies, materials, arguments.samples, arguments.rounds)
            spreads = {key: Spread(each) for key, each in taken.items()}
            ratio = Spread([a / b for a, b in zip(taken["diffraction"], taken["principled"], strict=True)])
            (ours, our_share), (plain, plain_share) = noises["diffraction"], noises["principled"]
            equal = ratio.median * ours / plain if plain else None
            numbers[name] = {
                "seconds": {key: spread.to_json() for key, spread in spreads.items()},
                "over_principled": ratio.to_json(),
                "noise": {"diffraction": ours, "principled": plain},
                "variance_in_noisiest_hundredth": {"diffraction": our_share, "principled": plain_share},
                "over_principled_equal_noise": equal,
            }
            print(
                f"{name}, {arguments.samples} samples, {arguments.rounds} rounds: Principled {spreads['principled']},"
                f" diffraction {spreads['diffraction']}: {ratio.median:.2f} times (+-{50 * ratio.width:.0f} %)\n"
                f"  relative variance of a lit pixel with {few(arguments.samples)} samples, median: {plain:.1e} and"
                f" {ours:.1e}; the noisiest hundredth of the pixels has {plain_share:.0%} and {our_share:.0%} of the"
                " whole variance",
                flush=True,
            )
    numbers["quiet"] = warn_if_busy()
    merge("cycles", numbers)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit


if __name__ == "__main__":
    main()
