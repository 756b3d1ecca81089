# SPDX-License-Identifier: GPL-3.0-or-later
"""The large pictures of docs/gallery.md: `gallery_page.py [NAME ...] [--scale S] [--samples N] [--out FOLDER]`.

1920 x 1080, rendered by Cycles and cleared of noise by Open Image Denoise. A scale of 0.25 and 8 samples make a draft.
The scenes stay in out/gallery/ as .blend files.
"""

import argparse
import importlib
import os
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

#: Pictures made of one frame: name, and samples a pixel.
FRAMES = {"skins": 20, "snake_sun": 24, "snake_studio": 20, "disc": 32, "plates": 24, "foil": 24, "stuff": 6}

#: Pictures made of several frames side by side: the frames are `disc.LAMPS`.
STRIPS = {"disc_lamps": 16}

WIDTH, HEIGHT = 1920, 1080


def render(path, width, height, samples):
    """Render the scene as it stands to a JPEG or PNG."""
    import bpy

    scene = bpy.context.scene
    scene.render.engine, scene.cycles.device = "CYCLES", "CPU"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling, scene.cycles.adaptive_threshold = True, 0.03
    scene.cycles.use_denoising, scene.cycles.denoiser = True, "OPENIMAGEDENOISE"
    settings = scene.render.image_settings
    settings.file_format = "JPEG" if path.suffix == ".jpg" else "PNG"
    settings.color_mode, settings.quality = "RGB", 90
    for name in dir(scene.render):  # no date, no paths of this computer in the file
        if name.startswith("use_stamp"):
            setattr(scene.render, name, False)
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def frame(name, path, scale, samples):
    """One picture; its scene is kept."""
    import bpy

    importlib.import_module(f"tools.docs.gallery.{name}").build(ROOT / "out" / "gallery")
    bpy.ops.wm.save_mainfile()
    render(path, round(WIDTH * scale), round(HEIGHT * scale), samples)


def strip(path, scale, samples):
    """The disc under several lamps, side by side."""
    import numpy as np
    from PIL import Image

    from tools.docs.gallery import disc

    frames = []
    with tempfile.TemporaryDirectory() as folder:
        for index, lamp in enumerate(disc.LAMPS):
            disc.build(Path(folder), lamp, alone=True)
            part = Path(folder) / f"{index}.png"
            side = round(WIDTH / len(disc.LAMPS) * scale)
            render(part, side, side, samples)
            frames.append(np.asarray(Image.open(part)))
    Image.fromarray(np.concatenate(frames, 1)).save(path, quality=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", default=[*FRAMES, *STRIPS], help="by default all")
    parser.add_argument("--scale", type=float, default=1.0)
    parser.add_argument("--samples", type=int, help="a pixel; by default each picture's own")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "pictures")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    from reference import register

    register()
    for name in arguments.names:
        start, path = time.perf_counter(), arguments.out.resolve() / f"{name}.jpg"
        if name in STRIPS:
            strip(path, arguments.scale, arguments.samples or STRIPS[name])
        else:
            frame(name, path, arguments.scale, arguments.samples or FRAMES[name])
        print(f"{name}: {time.perf_counter() - start:.0f} s, {path.stat().st_size / 1e3:.0f} kB", flush=True)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


if __name__ == "__main__":
    main()
