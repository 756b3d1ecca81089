# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/paint.png: each recipe of grating paint under a small lamp, by numpy. `paint_pictures.py [OUT]`.

Small ones of each go to addon/paint_pictures/ for the panel; they ship with the extension.
"""

import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.bake import bake  # noqa: E402
from precompute.evaluate import map_to_srgb  # noqa: E402
from precompute.evaluate.scaled import painted_brdf  # noqa: E402
from precompute.files import write_png  # noqa: E402
from precompute.paint import RECIPES, make_paint  # noqa: E402
from precompute.parameters import BakeParameters  # noqa: E402
from precompute.presets import make_preset  # noqa: E402

PERIOD, SIDE, GAP = 1.6e-6, 300, 8

#: The surface reaches from -1 to 1; eye and lamp in the same unit, the lamp to the right of the eye and above.
EYE, LAMP = np.array([0.0, 0.0, 6.0]), np.array([3.4, 1.0, 5.0])

#: What differs from the recipe's own settings, and from the common lamp.
SETTINGS = {
    "rays": {"turns": 3},
    "rings": {"bands": 7},
    "spiral": {"pitch_deg": 35.0},
    "guilloche": {"petals": 9, "lines": 16},
    "dots": {"cells": 28},
    "glitter": {"cells": 40},
    "lens": {"focus_mm": 45.0},
    "stereo": {"lamp_deg": 34.0, "eye_deg": 4.0},
    "picture": {"lamp_deg": 34.0},
}


def rainbow(side):
    """A wheel of hues that pales and darkens outwards: what `picture` is to show."""
    axis = (np.arange(side) + 0.5) * (2.0 / side) - 1.0
    x, y = np.meshgrid(axis, axis)
    hue = np.mod(np.arctan2(y, x) / (2 * np.pi), 1.0)[..., None]
    rgb = np.clip(np.abs(np.mod(6.0 * hue + np.array([0.0, 4.0, 2.0]), 6.0) - 3.0) - 1.0, 0.0, 1.0)
    petals = np.hypot(x, y) < 0.62 + 0.3 * np.cos(5 * np.arctan2(y, x))
    return rgb**2.2 * petals[..., None] * (0.25 + 0.75 * np.clip(np.hypot(x, y), 0, 1))[..., None]


def letter(side, right):
    """L or R, for the two eyes."""
    picture = np.zeros((side, side))
    a, b, c = round(0.25 * side), round(0.4 * side), round(0.75 * side)
    picture[a:c, a:b] = 1.0
    if right:
        picture[c - (b - a) : c, a:c] = 1.0
        picture[round(0.48 * side) : round(0.48 * side) + (b - a), a:c] = 1.0
        picture[round(0.55 * side) : c, c - (b - a) : c] = 1.0
        for row in range(a, round(0.5 * side)):
            start = round(0.5 * side) + round(0.5 * side) - row
            picture[row, min(start - (b - a) // 2, c - 1) : min(start + (b - a) // 2, c)] = 1.0
    else:
        picture[a:b, a:c] = 1.0
    return np.repeat(picture[..., None], 3, axis=-1)


def towards(place, points):
    """``(rows, cols, 3)`` unit vectors from the surface to a place."""
    away = place - points
    return away / np.linalg.norm(away, axis=-1, keepdims=True)


def main(target):
    table = bake(make_preset("sinusoid", 60e-6, 800, period_um=PERIOD * 1e6, amplitude_nm=40), BakeParameters(
        sigma_s_m=6e-6, level="none"))  # fmt: skip
    axis = (np.arange(SIDE) + 0.5) * (2.0 / SIDE) - 1.0
    points = np.stack([*np.meshgrid(axis, axis), np.zeros((SIDE, SIDE))], axis=-1)
    shots = []
    for name, recipe in RECIPES.items():
        pictures = [rainbow(SIDE)] if name == "picture" else [letter(SIDE, right) for right in (False, True)]
        more = {"sigma_s_um": 6.0} if name == "picture" else {}
        paint = make_paint(name, PERIOD, SIDE, pictures=pictures[: recipe.pictures], **SETTINGS[name], **more)
        # Pictures for one direction are seen from afar, as they were designed; the rest from near, as in a hand.
        far = name in ("picture", "stereo")
        eye, lamp = (60.0 * EYE, 60.0 * np.array([np.tan(np.radians(34.0)), 0.0, 1.0])) if far else (EYE, LAMP)
        if name == "stereo":
            eye = 60.0 * np.array([-np.sin(np.radians(4.0)), 0.0, np.cos(np.radians(4.0))])
            lamp = 60.0 * np.array([0.0, np.sin(np.radians(34.0)), np.cos(np.radians(34.0))])
        xyz = painted_brdf(table, towards(lamp, points), towards(eye, points), *paint.maps)
        shots.append(map_to_srgb(xyz, 1.5 / np.quantile(xyz[..., 1], 0.985)))
    small = ROOT / "addon" / "paint_pictures"
    small.mkdir(exist_ok=True)
    for name, shot in zip(RECIPES, shots, strict=True):
        picture = Image.fromarray((np.clip(shot[::-1], 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8))
        picture.resize((96, 96), Image.Resampling.LANCZOS).quantize(128).save(small / f"{name}.png", optimize=True)
    columns = 3
    rows = -(-len(shots) // columns)
    sheet = np.full((rows * (SIDE + GAP) - GAP, columns * (SIDE + GAP) - GAP, 3), 0.12)
    for index, shot in enumerate(shots):
        top = (rows - 1 - index // columns) * (SIDE + GAP)
        left = index % columns * (SIDE + GAP)
        sheet[top : top + SIDE, left : left + SIDE] = shot
    write_png(target, sheet)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures" / "paint.png")
