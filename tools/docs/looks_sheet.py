# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/looks.jpg: every finished material of the asset library, with its name.

``looks_sheet.py [NAME ...] [--out FILE] [--detail D] [--samples N] [--implementation OSL|NODES]``; Open Image Denoise
clears the pictures of noise.
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="diffraction_looks_"))
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

import bpy  # noqa: E402
import numpy as np  # noqa: E402

from tests.support.blender import extension  # noqa: E402

#: Pixels of a picture, of the name below it, and pictures a row.
SIDE, NAME, COLUMNS = 208, 26, 6

#: Grey behind the pictures and colour of the names.
GROUND, INK = (38, 39, 42), (222, 222, 222)


def shots(chosen, detail, samples, implementation):
    """Name and ``(SIDE, SIDE, 4)`` picture of each material, top row first."""
    extension.load().register()
    from diffraction_shader.addon.assets import library, stage

    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.render.engine, scene.render.threads_mode = "CYCLES", "AUTO"
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "scene.blend"))
        shapes = stage.build(scene)
        scene.cycles.use_denoising, scene.cycles.denoiser = True, "OPENIMAGEDENOISE"
        for asset in library.ASSETS:
            if chosen and asset.name not in chosen and asset.preset not in chosen:
                continue
            material = library.make_material(asset, shapes[asset.shape], detail, implementation)
            pixels = stage.picture(scene, material, shapes, asset.shape, asset.bright, samples, SIDE)
            yield asset.name, pixels.reshape(SIDE, SIDE, 4)[::-1]


def main():
    from PIL import Image, ImageDraw, ImageFont

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="materials or presets; by default all")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "pictures" / "looks.jpg")
    parser.add_argument("--detail", type=float, default=1.0)
    parser.add_argument("--samples", type=int, default=48)
    parser.add_argument("--implementation", default="OSL")
    arguments = parser.parse_args()
    made = []
    for name, pixels in shots(arguments.names, arguments.detail, arguments.samples, arguments.implementation):
        made.append((name, pixels))
        print(name, flush=True)
    rows = -(-len(made) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * SIDE, rows * (SIDE + NAME)), GROUND)
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(13)
    for index, (name, pixels) in enumerate(made):
        at = (index % COLUMNS * SIDE, index // COLUMNS * (SIDE + NAME))
        cut = (np.clip(pixels, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
        picture = Image.fromarray(cut, "RGBA")
        sheet.paste(picture, at, picture)
        pen.text((at[0] + SIDE // 2, at[1] + SIDE + NAME // 2 - 2), name, INK, font, anchor="mm")
    sheet.save(arguments.out, quality=88)
    print(arguments.out, flush=True)
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


if __name__ == "__main__":
    main()
