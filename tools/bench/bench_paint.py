# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what Scale and Depth cost in Cycles, and what noise they bring in an environment.

`bench_paint.py [--samples N] [--rounds N] [--width W]`

A sphere under one sun and a sky, the material's environment at 1. In turn, for OSL and for nodes: the material with its
sockets at 1, the same with Scale and Depth taken out of the shader (OSL alone), the same under a paint (one image for
four sockets), and a Principled BSDF without and with that image on four of its sockets. User time of the processor, the
difference of two renders with many and few samples; medians of the rounds. Noise: the relative spread of the pixels of
a plane in a sky that is brighter to one side, over that at Scale and Depth 1. And how long each recipe takes for
1,024 x 1,024. Merged into out/bench.json under "paint".
"""

import argparse
import os
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools.bench import bench_cycles  # noqa: E402

#: Scale and Depth at which noise is measured.
PAIRS = ((1.0, 1.0), (0.9, 0.9), (0.8, 1.0), (1.0, 0.8), (0.7, 0.7), (0.5, 0.5), (1.0, 0.3))


def recipe_seconds():
    """Seconds that each recipe takes for 1,024 x 1,024, wall time; pictures are colours of all hues."""
    from precompute.paint import RECIPES, make_paint

    hue = np.linspace(0.0, 6.0, 512)
    rgb = np.clip(np.abs(hue[:, None] - np.array([3.0, 2.0, 4.0])) * np.array([1, -1, -1]) + [-1, 2, 2], 0, 1)
    picture, found = np.repeat(rgb[None], 512, 0), {}
    for name, recipe in RECIPES.items():
        start = time.perf_counter()
        make_paint(name, 1.6e-6, 1024, pictures=[picture] * recipe.pictures)
        found[name] = time.perf_counter() - start
    return found


def user_seconds(samples):
    """Processor time of the samples, without the setting up."""

    def one(count):
        before = resource.getrusage(resource.RUSAGE_SELF).ru_utime
        bench_cycles.render(count)
        return resource.getrusage(resource.RUSAGE_SELF).ru_utime - before

    return one(samples) - one(bench_cycles.few(samples))


def principled(image=None):
    """A Principled BSDF, four of whose sockets may follow an image."""
    import bpy

    material = bench_cycles.principled()
    if image is not None:
        tree = material.node_tree
        picture, split = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeSeparateColor")
        picture.image, picture.interpolation = image, "Closest"
        tree.links.new(picture.outputs["Color"], split.inputs[0])
        node = tree.nodes["Principled BSDF"]
        for output, name in (("Red", "Roughness"), ("Green", "Metallic"), ("Blue", "Coat Weight")):
            tree.links.new(split.outputs[output], node.inputs[name])
        tree.links.new(picture.outputs["Alpha"], node.inputs["Sheen Weight"])
        assert isinstance(material, bpy.types.Material)
    return material


def ours(body, table, implementation, painted=None, without=False):
    """The add-on's material on a fresh material; `without` takes the sockets out of the OSL source."""
    import bpy
    from diffraction_shader.addon.materials import handlers, material, osl
    from diffraction_shader.addon.materials.node import paint_nodes

    source = osl.source
    if without:
        scales = (
            "float scale = Scale >= SCALE_LEAST ? Scale : SCALE_LEAST,"
            " depth = Depth >= SCALE_LEAST ? Depth : SCALE_LEAST;"
        )

        def patched(*arguments, **options):
            text = source(*arguments, **options)
            assert scales in text
            return text.replace(scales, "float scale = 1.0, depth = 1.0;")

        osl.source = patched
    try:
        made = bpy.data.materials.new(implementation)
        made.use_nodes = True
        made.node_tree.nodes.clear()
        settings = material.Settings(implementation=implementation, ior=1.5)
        material.apply(made, table, settings)
        if without:  # a group of its own: the next material would change it
            node = material.shader_node(made)
            node.node_tree = node.node_tree.copy()
    finally:
        osl.source = source
    if painted is not None:
        paint_nodes.wire(made, painted)
    handlers.update_all()
    return made


def on(body, material):
    """Put a material on a body."""
    body.data.materials.clear()
    body.data.materials.append(material)


def costs(body, materials, samples, rounds):
    """Median user seconds by material, measured in turn."""
    taken = {name: [] for name in materials}
    for number in range(rounds):
        for name, material in materials.items():
            on(body, material)
            if number == 0:
                bench_cycles.render(1)  # compiles, loads
            taken[name].append(user_seconds(samples))
    return {name: float(np.median(each)) for name, each in taken.items()}


def sky():
    """A world brighter towards x."""
    import bpy

    world = bpy.data.worlds.new("sky")
    world.use_nodes = True
    tree = world.node_tree
    place, split, add = (tree.nodes.new(f"ShaderNode{name}") for name in ("TexCoord", "SeparateXYZ", "Math"))
    add.inputs[1].default_value = 1.2
    tree.links.new(place.outputs["Generated"], split.inputs[0])
    tree.links.new(split.outputs["X"], add.inputs[0])
    tree.links.new(add.outputs[0], tree.nodes["Background"].inputs["Strength"])
    bpy.context.scene.world = world


def noises(body, material, theta):
    """Relative spread of the pixels of a plane seen at an angle, for `PAIRS`."""
    import bpy
    from diffraction_shader.addon.materials import material as materials

    for lamp in [ob for ob in bpy.context.scene.objects if ob.type == "LIGHT"]:
        lamp.hide_render = True
    node, found = materials.shader_node(material), {}
    on(body, material)
    body.rotation_euler = (0.0, np.radians(theta), 0.3)
    for scale, depth in PAIRS:
        node.inputs["Scale"].default_value, node.inputs["Depth"].default_value = scale, depth
        pixels = bench_cycles.render(16)[0].sum(-1)
        found[f"{scale:g} {depth:g}"] = float(pixels.std() / pixels.mean())
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--width", type=int, default=bench_cycles.WIDTH, help="pixels; three quarters as high")
    parser.add_argument("--kinds", nargs="*", default=["OSL", "NODES"], help="implementations whose cost is measured")
    parser.add_argument("--no-noise", action="store_true")
    parser.add_argument("--structures", nargs="+", default=["sinusoid", "foil", "snake", "blazed"])
    arguments = parser.parse_args()
    bench_cycles.WIDTH, bench_cycles.HEIGHT = arguments.width, arguments.width * 3 // 4
    import bpy

    from tests.support.blender import extension
    from tools.bench.results import merge

    packages = Path(
        bpy.utils.resource_path("LOCAL"), "python", "lib", f"python3.{sys.version_info[1]}", "site-packages"
    )
    sys.path.append(str(packages))
    extension.load().register()
    from diffraction_shader.addon.materials.node import paint_nodes
    from diffraction_shader.precompute.bake import bake
    from diffraction_shader.precompute.paint import make_paint, save_paint
    from diffraction_shader.precompute.parameters import BakeParameters
    from diffraction_shader.precompute.presets import make_preset

    numbers = {"samples": arguments.samples, "rounds": arguments.rounds, "costs": {}, "noise": {}}
    numbers["recipes"] = recipe_seconds()
    print(
        "seconds for 1,024 x 1,024:", {name: round(value, 2) for name, value in numbers["recipes"].items()}, flush=True
    )
    with tempfile.TemporaryDirectory() as folder:
        for number, name in enumerate(arguments.structures):
            bpy.ops.wm.read_factory_settings(use_empty=True)
            bpy.ops.wm.save_as_mainfile(filepath=str(Path(folder) / f"{name}.blend"))
            table = Path(folder) / f"{name}.exr"
            bake(make_preset(name, 24e-6, 384), BakeParameters(sigma_s_m=2.4e-6, level="none")).save(table)
            (body,) = bench_cycles.sphere_scene()
            sky()
            if number == 0:
                paint = make_paint("glitter", 1e-6, 1024, least_scale=0.5)
                image = paint_nodes.load(save_paint(paint, Path(folder) / "p.exr"))
                for kind in arguments.kinds:
                    made = {
                        "constant": ours(body, table, kind), "painted": ours(body, table, kind, image),
                        "principled": principled(), "principled, images": principled(image),
                    }  # fmt: skip
                    if kind == "OSL":
                        made = {"without": ours(body, table, kind, without=True), **made}
                    found = costs(body, made, arguments.samples, arguments.rounds)
                    numbers["costs"][kind] = found
                    images = found["principled, images"] - found["principled"]
                    words = (
                        [f"constant sockets {found['constant'] / found['without']:.3f}"] if "without" in found else []
                    )
                    words.append(f"painted {(found['painted'] - images) / found['constant']:.3f} without its images,")
                    words.append(f"{found['painted'] / found['constant']:.3f} with them")
                    print(f"{kind}: {' '.join(words)}", {k: round(v, 2) for k, v in found.items()}, flush=True)
            if arguments.no_noise:
                break
            mesh = bpy.data.meshes.new("plane")
            mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
            mesh.uv_layers.new(name="UVMap")
            body.data = mesh
            made = ours(body, table, "OSL")
            for theta in (0, 40):
                found = noises(body, made, theta)
                numbers["noise"][f"{name} {theta}"] = found
                first = found["1 1"]
                print(name, theta, "degrees, noise over that at 1 1:",
                      {key: round(value / first, 2) for key, value in found.items()}, flush=True)  # fmt: skip
    merge("paint", numbers)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit


if __name__ == "__main__":
    main()
