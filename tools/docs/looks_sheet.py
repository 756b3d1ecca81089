# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/looks.jpg: every finished material of the asset library, with its name.

``looks_sheet.py [NAME ...] [--out FILE] [--keep FOLDER] [--detail D] [--samples N] [--side PIXELS]``; Open Image
Denoise clears the pictures of noise.
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


def shots(keep, arguments, side):
    """Name and picture of each material; those in the folder `keep` are taken as they are, the others go there."""
    from PIL import Image

    extension.load().register()
    from diffraction_shader.addon.assets import library, stage

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.wm.save_as_mainfile(filepath=str(keep / "scene.blend"))
    shapes = stage.build(scene)
    scene.cycles.use_denoising, scene.cycles.denoiser = True, "OPENIMAGEDENOISE"
    for asset in library.ASSETS:
        if arguments.names and asset.name not in arguments.names:
            continue
        path = keep / f"{asset.name.replace('/', ' ')}.png"
        if not path.is_file():
            library.make_material(asset, shapes[asset.shape], arguments.detail, arguments.implementation)
            pixels = stage.picture(scene, shapes, asset, arguments.samples, side)
            cut = (np.clip(pixels, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8).reshape(side, side, 4)[::-1]
            Image.fromarray(cut, "RGBA").save(path)
        yield asset.name, Image.open(path).copy()


def main():
    from PIL import Image, ImageDraw, ImageFont

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="materials; by default all")
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "pictures" / "looks.jpg")
    parser.add_argument("--detail", type=float, default=1.0)
    parser.add_argument("--samples", type=int, default=32)
    parser.add_argument("--side", type=int, default=SIDE)
    parser.add_argument("--keep", type=Path, help="folder of single pictures, which are not made again")
    parser.add_argument("--implementation", default="OSL")
    arguments = parser.parse_args()
    side = arguments.side
    with tempfile.TemporaryDirectory() as folder:
        keep = arguments.keep or Path(folder)
        keep.mkdir(parents=True, exist_ok=True)
        made = []
        for name, picture in shots(keep, arguments, side):
            made.append((name, picture))
            print(name, flush=True)
    rows = -(-len(made) // COLUMNS)
    sheet = Image.new("RGB", (COLUMNS * side, rows * (side + NAME)), GROUND)
    pen, font = ImageDraw.Draw(sheet), ImageFont.load_default(13)
    for index, (name, picture) in enumerate(made):
        at = (index % COLUMNS * side, index // COLUMNS * (side + NAME))
        sheet.paste(picture, at, picture)
        pen.text((at[0] + side // 2, at[1] + side + NAME // 2 - 2), name, INK, font, anchor="mm")
    sheet.save(arguments.out, quality=88)
    print(arguments.out, flush=True)
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


if __name__ == "__main__":
    main()
