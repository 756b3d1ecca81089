# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the guide: the levelling preview of the snake preset, and the asset library's materials.

`guide_pictures.py FOLDER`, with Blender as a module.
"""

import importlib.util
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

#: Materials on the sheet.
SHOWN = ("Sunbeam Snake", "Corn Snake", "CD", "Jewel Beetle", "Holographic Foil", "Trading Card")


def levelling(path):
    """The preview of a tilted piece of snake skin with a grain of dust."""
    from dataclasses import replace

    from precompute.files.images import write_png
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset
    from precompute.scan.levelling_picture import levelling_picture
    from precompute.scan.preparation import prepare

    scan = make_preset("snake")
    y, x = np.mgrid[: scan.shape[0], : scan.shape[1]] / scan.shape[0]
    dust = 600e-9 * np.exp(-((x - 0.7) ** 2 + (y - 0.3) ** 2) / (2 * 0.012**2))
    scan = replace(scan, heights=scan.heights + 300e-9 * x - 150e-9 * y + dust)
    write_png(path, levelling_picture(scan, prepare(scan, BakeParameters(level="poly2", clip_percent=99.5))))


def assets(path):
    """The previews of the asset library side by side."""
    from reference import register

    register()
    spec = importlib.util.spec_from_file_location("build_assets", ROOT / "sample_blend" / "build_assets.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules["build_assets"] = module
    spec.loader.exec_module(module)
    from precompute.files.images import write_png

    with tempfile.TemporaryDirectory() as folder:
        made = module.build_assets(Path(folder) / "assets.blend", only=SHOWN, samples=48, side=256)
        tiles = [np.array(m.preview.image_pixels_float[:]).reshape(*m.preview.image_size, 4) for m in made]
    tiles = [tile[..., :3] * tile[..., 3:] + 0.11 * (1.0 - tile[..., 3:]) for tile in tiles]
    half = (len(tiles) + 1) // 2
    # Row 0 is the bottom.
    write_png(path, np.concatenate([np.concatenate(tiles[half:], 1), np.concatenate(tiles[:half], 1)], 0))


def main():
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else ROOT / "docs" / "pictures")
    levelling(folder / "levelling.png")
    assets(folder / "assets.png")


if __name__ == "__main__":
    main()
