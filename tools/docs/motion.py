# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/motion.webp: a compact disc and a sunbeam snake while a lamp swings there and back, for the README.

``motion.py [--frames N] [--width W] [--samples S] [--out FILE]``. Only the lamp moves. The frames of the way there
serve for the way back as well. Open Image Denoise clears them of noise.
"""

import argparse
import math
import os
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
sys.path.insert(0, str(ROOT / "tools" / "docs"))

#: Length of the loop in seconds, and most bytes of the file.
SECONDS, LIMIT = 3.0, 4_000_000


def lamp_place(share):
    """Where the lamp stands at a share of the way: an arc over the camera, slow at its ends like a pendulum."""
    swing = -math.cos(math.pi * share)
    return 0.40 * swing, -0.22 + 0.20 * swing**2, 0.55 - 0.08 * swing**2


def build(folder):
    """The scene; returns its lamp."""
    from tools.docs.gallery import disc, skins, stage

    scene = stage.empty_room(folder / "motion.blend", (0.030, 0.034, 0.042))
    slate = stage.plain("Slate", (0.004, 0.004, 0.0045), 0.4)
    stage.table_top(2.0, slate)
    data = disc.disc("CD")
    data.location, data.rotation_euler = (0.0, 0.070, 0.036), [math.radians(a) for a in (34.0, 0.0, 0.0)]
    stage.diffract([data], "cd", fresnel="CONDUCTOR", orientation="RADIAL")
    snake = skins.body("Snake", *skins.winding((-0.22, -0.030), (0.24, -0.036), 0.015, 1.6, 0.0150))
    skins.scaled([snake], "SUNBEAM", "UV")
    lamp = stage.bulb("Lamp", lamp_place(0.0), 20.0, 0.006)
    stage.camera((0.0, -0.31, 0.24), (0.0, 0.020, 0.026), 54)
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Punchy"
    scene.view_settings.exposure = 0.6
    scene.cycles.sample_clamp_indirect = 1.0
    scene.render.use_persistent_data = True
    return lamp


def main():
    from PIL import Image

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, default=14)
    parser.add_argument("--width", type=int, default=480)
    parser.add_argument("--samples", type=int, default=10)
    parser.add_argument("--out", type=Path, default=ROOT / "docs" / "pictures" / "motion.webp")
    arguments = parser.parse_args()
    from gallery_page import render
    from reference import register

    register()
    start, frames = time.perf_counter(), []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        lamp = build(folder)
        for index in range(arguments.frames):
            lamp.location = lamp_place(index / max(arguments.frames - 1, 1))
            render(folder / "frame.png", arguments.width, arguments.width * 9 // 16, arguments.samples)
            frames.append(Image.open(folder / "frame.png").convert("RGB").copy())
            print(f"{index + 1} of {arguments.frames}, {time.perf_counter() - start:.0f} s", flush=True)
    first, *others = frames + frames[-2:0:-1]
    for quality in (82, 70, 55, 40):
        first.save(
            arguments.out, save_all=True, append_images=others, loop=0, quality=quality, method=6,
            duration=round(1000.0 * SECONDS / (1 + len(others))),
        )  # fmt: skip
        if arguments.out.stat().st_size <= LIMIT:
            break
    print(f"{arguments.out.name}: {arguments.out.stat().st_size / 1e3:.0f} kB, quality {quality}", flush=True)
    os._exit(0)  # Blender as a module may crash at exit once it has drawn


if __name__ == "__main__":
    main()
