# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/pictures/presets.png: ten micrometres of every preset, and its BRDF map under light from 20 degrees."""

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.bake.baking import bake  # noqa: E402
from precompute.evaluate.directions import from_angles  # noqa: E402
from precompute.evaluate.disc_map import brdf_map, map_to_srgb  # noqa: E402
from precompute.parameters import BakeParameters  # noqa: E402
from precompute.presets import PRESETS, make_preset  # noqa: E402
from precompute.scan.levelling import level  # noqa: E402

_SIDE_M = 10e-6
_MAP_PIXELS = 360
_COLUMNS = 4


def heights_crop(field):
    """The lower left 10 um of the levelled heights, in nm."""
    rows, cols = round(_SIDE_M / field.dy), round(_SIDE_M / field.dx)
    return 1e9 * level(field, "plane").heights[:rows, :cols]


def draw(path):
    """Draw all presets into one picture."""
    from matplotlib.figure import Figure

    names = [name for name in PRESETS if name != "flat"]
    rows = -(-len(names) // _COLUMNS)
    figure = Figure(figsize=(4.2 * _COLUMNS, 2.45 * rows), dpi=100, layout="constrained")
    axes = figure.subplots(rows, 2 * _COLUMNS)
    for axis in axes.flat:
        axis.axis("off")
    wi = from_angles(np.radians(20.0), np.radians(45.0))
    for number, name in enumerate(names):
        left, right = axes[number // _COLUMNS, 2 * (number % _COLUMNS) :][:2]
        field = make_preset(name)
        left.imshow(heights_crop(field), cmap="gray", origin="lower", interpolation="nearest")
        left.set_title(PRESETS[name].label, fontsize=9, loc="left")
        table = bake(field, BakeParameters(level="plane"))
        right.imshow(map_to_srgb(brdf_map(table, wi, _MAP_PIXELS)), origin="lower")
        print(name, flush=True)
    figure.savefig(path)


if __name__ == "__main__":
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "pictures" / "presets.png"
    draw(target)
    print(target)
