# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies outside the working spaces, and what the gamut step does to it."""

import numpy as np

from precompute.bake.baking import bake
from precompute.evaluate.colour_difference import delta_e_2000
from precompute.evaluate.directions import from_angles
from precompute.evaluate.disc_map import disc_directions
from precompute.evaluate.surface import brdf
from precompute.light.colour import SPACES, into_gamut, luminance_row, xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import make_preset

from .common import scans, snake

#: Pixels of the disc of views, even in cos(theta) d omega; the light's angles; radius of the specular peak.
SIZE, LIGHTS_DEG, PEAK = 301, (20.0, 50.0), 0.1


def surfaces():
    """Tables by their names on the page."""
    found = {f"{name} (scan)": (field, {}) for name, field in scans().items() if name.startswith("Xenopeltis")}
    found["snake (preset)"] = (snake(40, 640), {"sigma_s_m": 4e-6})
    found["cd (preset)"] = (make_preset("cd"), {})
    return {name: bake(field, BakeParameters(**options)) for name, (field, options) in found.items()}


def colours(table):
    """XYZ of f towards all views for some lights, and which of them lie off the specular peak."""
    views, inside = disc_directions(SIZE)
    xyz, off = [], []
    for theta in np.radians(LIGHTS_DEG):
        light = from_angles(theta, 0.6)
        xyz.append(brdf(table, light, views[inside], energy_conserving=True))
        off.append(np.hypot(*(light + views[inside])[:, :2].T) > PEAK)
    return np.concatenate(xyz), np.concatenate(off)


def effect(xyz, off, space):
    """What the step does in a space: shares of luminance outside, saturation, differences, luminance, hue."""
    matrix, row = xyz_to_rgb_matrix(space), luminance_row(space)
    rgb = xyz @ matrix.T
    moved = into_gamut(rgb, row)
    outside = (rgb.min(-1) < -1e-9 * np.abs(rgb).max(-1)) & (xyz[:, 1] > 0)
    luminance = xyz[:, 1]
    grey = luminance[:, None]
    before, after = (rgb - grey)[outside], (moved - grey)[outside]
    kept = np.linalg.norm(after, axis=-1) / np.linalg.norm(before, axis=-1)
    seen = outside & (luminance > 1e-3)
    back = np.linalg.solve(matrix, moved[seen].T).T
    cosine = (before * after).sum(-1) / (np.linalg.norm(before, axis=-1) * np.linalg.norm(after, axis=-1))
    return {
        "outside": luminance[outside].sum() / luminance.sum(),
        "outside off the peak": luminance[outside & off].sum() / luminance[off].sum(),
        "saturation": np.average(kept, weights=luminance[outside]),
        "delta E": np.percentile(delta_e_2000(back, xyz[seen]), [50, 95]),
        "luminance": np.abs(moved @ row - luminance)[luminance > 0].max() / luminance.max(),
        "turn": np.arccos(np.clip(cosine[kept > 1e-6], -1, 1)).max(),
    }


def run(pictures):
    """The block of docs/lighting.md."""
    from tools.docs.fill_page import table as page_table

    rows = []
    for name, baked in surfaces().items():
        xyz, off = colours(baked)
        for space in SPACES:
            found = effect(xyz, off, space)
            median, high = found["delta E"]
            rows.append([
                name, space, f"{100 * found['outside']:.0f} %", f"{100 * found['outside off the peak']:.0f} %",
                f"{100 * found['saturation']:.0f} %", f"{median:.1f}", f"{high:.1f}",
            ])  # fmt: skip
            print(name, space, found, flush=True)
    head = ["", "space", "luminance outside", "off the specular peak", "saturation kept", "Delta E median", "95 %"]
    return {"gamut": page_table(head, rows)}
