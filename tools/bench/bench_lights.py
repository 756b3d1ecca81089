# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure both implementations under 1, 2 and 8 suns against a Principled BSDF, and how quick lamps are in big files.

`bench_lights.py [--rounds N] [--lamps N ...] [--only costs|file] [--device CUDA|OPTIX|HIP|ONEAPI|METAL]`

Costs are processor time a sample, the difference of two renders of one thread, on a sphere that fills the picture with
one bounce of light; materials in turn, medians of the ratios of each round. With --device they are time of the wall on
all devices of that interface, of larger pictures. The second part takes the time that adding, renaming and deleting a
lamp takes in a file of 30 Nodes materials. Merged into out/bench.json under "lights".
"""

import argparse
import math
import os
import resource
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools import gpu_check  # noqa: E402

#: Name of a material here: implementation, environment.
MATERIALS = {
    "OSL": ("OSL", 0), "OSL, environment": ("OSL", 1), "Nodes": ("NODES", 0), "Nodes, environment": ("NODES", 1),
}  # fmt: skip

#: Pixels of a side, samples of the short and the long render: on a thread of the processor, on a GPU.
SIZES = {"CPU": (64, 4, 68), "GPU": (1024, 32, 544)}


def processor_time():
    """Seconds of this process."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def a_render(device):
    """Seconds of the long render over those of the short one."""
    from tests.support.blender import scenes

    size, *samples = SIZES["GPU" if device else "CPU"]
    clock = time.perf_counter if device else processor_time
    taken = []
    for number in samples:
        start = clock()
        scenes.render(size, number)
        taken.append(clock() - start)
    return taken[1] - taken[0]


def fresh_scene():
    """An empty file whose scene renders with Cycles in one thread, one bounce."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine, scene.cycles.shading_system, scene.cycles.max_bounces = "CYCLES", True, 1
    scene.render.threads_mode, scene.render.threads = "FIXED", 1
    return scene


def use_device(scene, interface):
    """Render on all devices of an interface of Cycles."""
    import bpy

    preferences = bpy.context.preferences.addons["cycles"].preferences
    if not gpu_check.device_names(preferences, interface):
        sys.exit(f"Cycles has no device of {interface} here.")
    gpu_check.use_device(preferences, interface)
    scene.cycles.device = "GPU"


def costs(table, lamps, rounds, device=None):
    """Ratios to Principled by material's name."""
    import numpy as np

    from tests.support.blender import materials, scenes
    from tools.bench.bench_cycles import principled

    scene = fresh_scene()
    if device:
        use_device(scene, device)
    sphere = scenes.add_sphere(segments=128, rings=64)
    for number in range(lamps):
        turn = 2 * math.pi * number / lamps
        scenes.add_sun((0.6 * math.cos(turn), 0.6 * math.sin(turn), 1.0), angle=0.009, name=f"sun {number}")
    scenes.add_camera(extent=1.4)
    shown = {"Principled": principled()}
    for name, (implementation, environment) in MATERIALS.items():
        if implementation == "OSL" and device and device not in gpu_check.WITH_OSL:
            continue
        shown[name] = materials.diffracting(sphere, table, implementation, environment=environment)
    seconds = {name: [] for name in shown}
    for _ in range(rounds):
        for name, material in shown.items():
            sphere.data.materials.clear()
            sphere.data.materials.append(material)
            scene.cycles.shading_system = name.startswith("OSL")
            seconds[name].append(a_render(device))
    plain = np.array(seconds["Principled"])
    return {name: float(np.median(np.array(each) / plain)) for name, each in seconds.items() if name != "Principled"}


def big_file(table, count=30):
    """Seconds that adding, renaming and deleting a lamp takes with so many materials of the kind Nodes."""
    import bpy

    from tests.support.blender import materials, scenes

    fresh_scene()
    scenes.add_sun((0.3, 0.2, 1.0))
    first = materials.diffracting(scenes.add_sphere(segments=16, rings=8), table, "NODES")
    for number in range(1, count):
        ob = scenes.add_sphere(f"sphere {number}", segments=16, rings=8)
        ob.data.materials.append(first.copy())
    bpy.context.view_layer.update()
    found, made = {}, []

    def timed(name, change):
        start = time.perf_counter()
        change()
        bpy.context.view_layer.update()
        found[name] = time.perf_counter() - start

    timed("add", lambda: made.append(scenes.add_sun((-0.4, 0.1, 1.0), name="new")))
    timed("rename", lambda: setattr(made[0], "name", "other"))
    timed("delete", lambda: bpy.data.objects.remove(made[0]))
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--lamps", type=int, nargs="+", default=[1, 2, 8])
    parser.add_argument("--device", choices=gpu_check.INTERFACES)
    parser.add_argument("--only", choices=["costs", "file"])
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        os.environ.setdefault("BLENDER_USER_RESOURCES", folder)
        import bpy

        from precompute.bake.baking import bake
        from precompute.parameters import BakeParameters
        from precompute.presets import make_preset
        from tests.support.blender import extension
        from tools.bench.results import merge

        version = f"python3.{sys.version_info[1]}"
        sys.path.append(str(Path(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages")))
        extension.load().register()
        table = Path(folder) / "snake.exr"
        parameters = BakeParameters(sigma_s_m=3e-6, level="poly2", detail=0.7)
        bake(make_preset("snake", 40e-6, 640), parameters).save(table)
        numbers = {}
        for lamps in arguments.lamps if arguments.only != "file" else []:
            numbers[str(lamps)] = costs(table, lamps, arguments.rounds, arguments.device)
            told = ", ".join(f"{name} {ratio:.2f}" for name, ratio in numbers[str(lamps)].items())
            where = f" on {arguments.device}" if arguments.device else ""
            print(f"{lamps} suns, times Principled{where}: {told}", flush=True)
        if arguments.only != "costs":
            numbers["30 Nodes materials, seconds"] = found = big_file(table)
            told = ", ".join(f"{name} {seconds:.3f} s" for name, seconds in found.items())
            print(f"a lamp with 30 Nodes materials: {told}", flush=True)
        merge(f"lights on {arguments.device}" if arguments.device else "lights", numbers)
        sys.stdout.flush()
        os._exit(0)  # Blender as a module may crash at exit


if __name__ == "__main__":
    main()
