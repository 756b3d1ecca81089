# SPDX-License-Identifier: GPL-3.0-or-later
"""The snake by Cycles, by the viewport's table and by FLSS, side by side: docs/pictures/viewport.png.

`viewport_pictures.py [--out FOLDER] [--width W] [--samples N] [--no-flss]`

No lamp casts shadows and no object sees another here, since the viewport knows neither shadows nor interreflection.
Prints the mean colour difference (Delta E 2000) between Cycles and the viewport.
"""

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PICTURES = ROOT / "docs" / "pictures"

#: Height over width, as the sample scene's camera frames it.
ASPECT = 0.75


def load_module(name, path, folders=None):
    """A module from a file, known under a name."""
    import importlib.util

    spec = importlib.util.spec_from_file_location(name, path, submodule_search_locations=folders)
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def make_table(folder, series):
    """Bake the preset snake; returns the table's path."""
    from diffraction_shader.precompute.bake.baking import bake_file
    from diffraction_shader.precompute.parameters import BakeParameters
    from diffraction_shader.precompute.presets import make_preset
    from diffraction_shader.precompute.scan.gsf import write_gsf

    scan = folder / "snake.gsf"
    write_gsf(make_preset("snake"), scan)
    return bake_file(scan, folder, BakeParameters(series=series)).path


def make_scene(table, detail):
    """The sample scene, every object blind to every other."""
    import bpy
    from diffraction_shader.addon.materials import material

    sample = load_module("diffraction_sample_scene", ROOT / "sample_blend" / "build_scene.py")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bodies = sample.build_scene(detail=detail)
    scene = bpy.context.scene
    for body in bodies:
        material.apply(body.active_material, str(table), material.Settings(ior=1.55))
    for ob in scene.objects:
        ob.visible_shadow = ob.visible_glossy = ob.visible_diffuse = ob.visible_transmission = False
    for lamp in (ob for ob in scene.objects if ob.type == "LIGHT"):
        lamp.visible_glossy = lamp.visible_diffuse = True
        lamp.data.use_shadow = False
    scene.render.dither_intensity = 0.0
    scene.eevee.taa_samples = 8
    return scene


def cycles(scene, path, width, samples):
    """Render with Cycles to a PNG."""
    import bpy

    scene.render.resolution_x, scene.render.resolution_y = width, round(width * ASPECT)
    scene.render.resolution_percentage = 100
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = False
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return read(path)


def viewport(path, width, **options):
    """Draw with the viewport to a PNG."""
    import bpy

    bpy.ops.diffraction.viewport_render(
        filepath=str(path), width=width, height=round(width * ASPECT), surface="REPLACE", shading="RENDERED", **options
    )
    return read(path)


def read(path):
    """Display values of a PNG, (rows, columns, 3)."""
    import matplotlib.image

    return matplotlib.image.imread(path)[..., :3].astype(float)


def delta_e(a, b):
    """Delta E 2000 of each pixel of two sRGB pictures."""
    import colour

    return colour.delta_E(*(colour.XYZ_to_Lab(colour.sRGB_to_XYZ(x)) for x in (a, b)), method="CIE 2000")


def side_by_side(pictures, path):
    """Write pictures next to each other with a narrow gap."""
    import matplotlib.image

    gap = np.ones((pictures[0].shape[0], 6, 3))
    parts = [part for picture in pictures for part in (picture, gap)][:-1]
    path.parent.mkdir(parents=True, exist_ok=True)
    matplotlib.image.imsave(path, np.concatenate(parts, axis=1))


def compare(folder, width=240, samples=200, viewport_samples=64, detail=0.3, flss=True):
    """Cycles, viewport and (optionally) FLSS pictures, and Delta E of the first two for each pixel."""
    table = make_table(folder, "taylor" if flss else "nodes")
    scene = make_scene(table, detail)
    pictures = [
        cycles(scene, folder / "cycles.png", width, samples),
        viewport(folder / "viewport.png", width, quality="MEDIUM", samples=viewport_samples),
    ]
    if flss:
        pictures.append(viewport(folder / "flss.png", width, quality="FAST", samples=1, method="FLSS"))
    return pictures, delta_e(*pictures[:2])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=PICTURES)
    parser.add_argument("--width", type=int, default=240)
    parser.add_argument("--samples", type=int, default=200)
    parser.add_argument("--no-flss", action="store_true")
    arguments = parser.parse_args()
    load_module("diffraction_shader", ROOT / "__init__.py", [str(ROOT)]).register()
    with tempfile.TemporaryDirectory() as folder:
        pictures, difference = compare(
            Path(folder), arguments.width, arguments.samples, arguments.samples // 3, flss=not arguments.no_flss
        )
    side_by_side(pictures, arguments.out.resolve() / "viewport.png")
    mean, median, high = difference.mean(), np.median(difference), np.percentile(difference, 95)
    print(f"Delta E 2000, Cycles and viewport: mean {mean:.2f}, median {median:.2f}, 95th percentile {high:.2f}")
    print(json.dumps({"delta_e_mean": mean, "delta_e_median": median}))
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


if __name__ == "__main__":
    main()
