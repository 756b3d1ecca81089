# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scans and tables that differ by a number; tables need no bake."""

import numpy as np

from precompute.parameters import BakeParameters
from precompute.scan.heightfield import HeightField
from precompute.table.cache import table_key
from precompute.table.layout import TableLayout
from precompute.table.table import SpectralTable


def small_scan(number, pixels=48):
    """A rough patch of 60 nm pixels."""
    rng = np.random.default_rng(number)
    return HeightField(40e-9 * rng.standard_normal((pixels, pixels)), 60e-9, 60e-9)


def small_table(number, n_r=40, n_phi=64):
    """A table of noise that knows its number and has all entries that a bake makes."""
    rng = np.random.default_rng(number)
    layout = TableLayout(n_r=n_r, n_phi=n_phi, n_w=4, r0=0.1, w0=0.4, w_min=0.1, tile_columns=2)
    atlas = rng.random((layout.height, layout.width, 3)).astype(np.float16)
    parameters = BakeParameters(sigma_s_m=1e-6 * (1 + number))
    info = {
        "key": table_key(small_scan(number, 4), parameters),
        "parameters": parameters.to_dict(),
        "source": {"name": f"scan {number}", "shape": [4, 4], "size_m": [1e-6, 1e-6], "processing": []},
        "colour": {"illuminant": "D65", "white_xyz": [0.95, 1.0, 1.09]},
        "terms": number,
        "albedo_max": 1.0,
    }
    return SpectralTable(layout, atlas, info)
