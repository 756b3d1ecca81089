# SPDX-License-Identifier: GPL-3.0-or-later
"""What the chapters share: real scans, patches, differences in words."""

import os
from pathlib import Path

import numpy as np

from precompute.evaluate.colour_difference import delta_e_2000
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.readers import read_scan
from precompute.scan.levelling import level
from precompute.scan.preparation import prepare

ROOT = Path(__file__).resolve().parents[3]

#: Real scans: file, what its reader must be told, and its name on the page.
SCANS = {
    "Xenopeltis, 65 um": ("xenopeltis_65um_818.69nm.png", {"size_m": (65e-6, 65e-6), "height_m": 818.69e-9}),
    "Hexagonal bumps, 15 um": ("hexagonal_bumps_15um.002", {}),
}


def scans():
    """``{name: prepared heightfield}`` of the real scans that are present."""
    folder = Path(os.environ.get("DIFFRACTION_SCAN_DIR", ROOT.parent / "shared" / "data"))
    return {
        name: prepare(read_scan(folder / file, **reading), BakeParameters(level="poly2", clip_percent=99.9))
        for name, (file, reading) in SCANS.items()
        if (folder / file).is_file()
    }


def snake(size_um, pixels):
    """A levelled piece of the snake preset."""
    return level(make_preset("snake", size_m=size_um * 1e-6, pixels=pixels), "plane")


def difference_cells(result, reference, exposure=None):
    """Median, 95th percentile and largest Delta E 2000 as cells of a table."""
    values = delta_e_2000(result, reference, exposure)
    return [_number(value) for value in np.percentile(values, [50, 95, 100])]


def _number(value):
    return f"{value:.2g}" if value < 1 else f"{value:.1f}"


def new_figure(width, height):
    """A figure that needs no window."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), dpi=80, layout="constrained")
