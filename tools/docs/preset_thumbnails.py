# SPDX-License-Identifier: GPL-3.0-or-later
"""addon/preset_pictures/: a small picture of every preset for the panel's menu; it ships with the extension.

``python tools/docs/preset_thumbnails.py [NAME ...]`` bakes each preset with the look that suits it and renders it.
"""

import os
import sys
import tempfile
from pathlib import Path

os.environ.setdefault("BLENDER_USER_RESOURCES", tempfile.mkdtemp(prefix="diffraction_thumbnails_"))
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

import bpy  # noqa: E402
import numpy as np  # noqa: E402

from tests.support.blender import extension  # noqa: E402

FOLDER = ROOT / "addon" / "preset_pictures"

#: Pixels a side: what a menu shows.
SIDE = 96


def draw(names):
    """Render the presets of these names."""
    from PIL import Image

    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages"))
    extension.load().register()
    from diffraction_shader.addon.assets import library, stage
    from diffraction_shader.precompute.presets import PRESETS, look_of

    FOLDER.mkdir(exist_ok=True)
    for name in names or PRESETS:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        scene = bpy.context.scene
        scene.render.engine = "CYCLES"
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(tempfile.mkdtemp(), "scene.blend"))
        shapes = stage.build(scene)
        look = look_of(name)
        asset = library.Asset(name, "", "", name, shape="DISC" if look.orientation == "RADIAL" else "BALL")
        library.make_material(asset, shapes[asset.shape], 1.0, "OSL")
        pixels = stage.picture(scene, shapes, asset, 64)
        pixels = pixels.reshape(stage.SIDE, stage.SIDE, 4)[::-1]
        picture = Image.fromarray((np.clip(pixels, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8), "RGBA")
        picture.resize((SIDE, SIDE), Image.LANCZOS).save(FOLDER / f"{name}.png", optimize=True)
        print(FOLDER / f"{name}.png", flush=True)


if __name__ == "__main__":
    draw(sys.argv[1:])
