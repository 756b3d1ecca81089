# SPDX-License-Identifier: GPL-3.0-or-later
"""Small tables with a known T(u, v, w), for tests that need no bake."""

import numpy as np

from precompute.table.albedo import albedo_map
from precompute.table.layout import TableLayout, near_square_columns, put_guard
from precompute.table.table import SpectralTable

WHITE = (0.95047, 1.0, 1.08883)


def make_table(path, transform, albedo=None, n_r=96, n_phi=120, n_w=12, power=1.0):
    """Save a table of `transform(u, v, w) -> (..., 3)` XYZ and return it.

    `albedo(theta, phi)` fills the albedo tile; without it the table says that the albedo stays below 1, "own" is what a
    bake would find.
    """
    layout = TableLayout(
        n_r=n_r, n_phi=n_phi, n_w=n_w, r0=0.2, w0=0.3, w_min=0.05, power=power, scale=0.01,
        tile_columns=near_square_columns(n_r, n_phi, n_w), n_theta=19, n_albedo_phi=24,
    )  # fmt: skip
    atlas = np.zeros((layout.height, layout.width, 3), np.float16)
    r, phi = np.meshgrid(layout.radii, layout.angles)
    for index, w in enumerate(layout.slices):
        x, y = layout.tile_origin(index)
        tile = atlas[y : y + layout.tile_height, x : x + layout.n_r]
        texels = transform(r * np.cos(phi), r * np.sin(phi), np.full_like(r, -w))
        tile[1:-1] = texels / (layout.scale * w**layout.power)
        tile[0], tile[-1] = tile[-2], tile[1]
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi / 2, layout.n_theta), np.arange(layout.n_albedo_phi) * 2 * np.pi / layout.n_albedo_phi
    )
    if albedo == "own":
        r, w, turn = np.meshgrid(layout.radii, layout.slices, layout.angles, indexing="ij")
        texels = transform(r * np.cos(turn), r * np.sin(turn), -w) / (w**layout.power)[..., None]
        values = albedo_map(np.moveaxis(texels, -1, 2).astype(np.float32), layout, np.asarray(WHITE))
    else:
        values = np.full_like(theta, 0.5) if albedo is None else albedo(theta, phi)
    tile = atlas[layout.albedo_y : layout.albedo_y + layout.albedo_height, : layout.n_theta]
    tile[1:-1] = values[..., None]
    tile[0], tile[-1] = tile[-2], tile[1]
    put_guard(atlas, layout)
    info = {
        "albedo_max": float(values.max()),
        "colour": {"illuminant": "D65", "adapted": "D65", "observer": "CIE 1931 2 degree", "white_xyz": list(WHITE)},
        "parameters": {},
        "source": {},
        "terms": 0,
    }
    table = SpectralTable(layout, atlas, info)
    table.save(path)
    return table


def lobes(u, v, w):
    """A smooth T without any symmetry: broad grey, a red lobe at u > 0, a green one at v > 0, a blue one between."""

    def bump(at_u, at_v, width):
        return np.exp(-((u - at_u) ** 2 + (v - at_v) ** 2) / (2 * width**2))

    grey = np.asarray(WHITE) * (0.6 * bump(0, 0, 0.25) + 0.05)[..., None]
    red = np.array([0.35, 0.2, 0.02]) * bump(0.5, 0.1, 0.2)[..., None]
    green = np.array([0.1, 0.3, 0.05]) * bump(-0.1, 0.6, 0.2)[..., None]
    blue = np.array([0.2, 0.1, 0.9]) * bump(-0.4, -0.5, 0.25)[..., None]
    return (grey + red + green + blue) * np.abs(w)[..., None]


def gentle(u, v, w):
    """`lobes` scaled to an albedo below 1."""
    return 0.3 * lobes(u, v, w)


def rising(theta, phi):
    """An albedo that passes 1 towards grazing, more so to one side."""
    return 0.8 + 0.6 * (theta / (np.pi / 2)) ** 2 * (1 + 0.3 * np.cos(phi))
