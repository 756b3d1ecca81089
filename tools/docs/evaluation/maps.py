# SPDX-License-Identifier: GPL-3.0-or-later
"""BRDF maps of all presets and of real scans, and what their bakes cost."""

import time

import numpy as np

from precompute.bake.baking import bake
from precompute.evaluate.directions import from_angles
from precompute.evaluate.disc_map import brdf_map, map_to_srgb
from precompute.parameters import BakeParameters
from precompute.presets import PRESETS, make_preset
from tools.docs.fill_page import table

from .common import new_figure, scans

_PIXELS = 200
_COLUMNS = 5


def _baked(field, parameters):
    start = time.perf_counter()
    made = bake(field, parameters)
    return made, time.perf_counter() - start


def _row(name, field, made, seconds):
    rows, cols = field.shape
    return [
        name,
        f"{cols} x {rows}",
        f"{1e9 * np.ptp(field.heights):.0f}",
        made.info["terms"],
        # Three half floats a texel, as a renderer loads them.
        f"{2 * made.atlas.size / 1e6:.0f}",
        f"{seconds:.1f}",
        f"{made.info['albedo_max']:.2f}",
    ]


_HEAD = ["", "pixels", "heights, nm", "kappa nodes", "table, MB", "bake, s", "largest albedo"]


def _draw(baked, path, columns):
    """Light from 20 degrees, from the lower left."""
    wi = from_angles(np.radians(20.0), np.radians(225.0))
    lines = -(-len(baked) // columns)
    figure = new_figure(2.2 * columns, 2.4 * lines)
    axes = np.atleast_1d(figure.subplots(lines, columns, squeeze=False)).ravel()
    for axis in axes:
        axis.axis("off")
    for axis, (name, made) in zip(axes, baked.items(), strict=False):
        axis.imshow(map_to_srgb(brdf_map(made, wi, _PIXELS)), origin="lower")
        axis.set_title(name, fontsize=8)
    figure.savefig(path)


def run(pictures):
    """Blocks `presets` and, where scans are present, `scans`."""
    blocks, rows, baked = {}, [], {}
    for name, preset in PRESETS.items():
        field = make_preset(name)
        made, seconds = _baked(field, BakeParameters(level="plane"))
        baked[preset.label] = made
        rows.append(_row(preset.label, field, made, seconds))
        print("map", name, flush=True)
    _draw(baked, pictures / "evaluation_presets.png", _COLUMNS)
    blocks["presets"] = table(_HEAD, rows)
    real = scans()
    if real:
        rows, baked = [], {}
        for name, field in real.items():
            made, seconds = _baked(field, BakeParameters())
            baked[name] = made
            rows.append(_row(name, field, made, seconds))
        _draw(baked, pictures / "evaluation_scans.png", len(baked))
        blocks["scans"] = table(_HEAD, rows)
    return blocks
