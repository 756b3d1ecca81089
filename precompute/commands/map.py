# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw the BRDF of a table towards all view directions as a PNG or EXR picture."""

from __future__ import annotations

import argparse
from typing import Any

from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """TABLE, the light's direction and the picture."""
    parser.add_argument("table", metavar="TABLE", help="the table's .exr or .json")
    parser.add_argument("--theta-i", type=options.number, required=True, metavar="T", help="light's polar angle, deg")
    parser.add_argument("--phi-i", type=options.number, required=True, metavar="P", help="light's azimuth, deg")
    parser.add_argument("--out", required=True, metavar="FILE", help=".png (sRGB) or .exr (linear Rec.709, 1/sr)")
    parser.add_argument("--size", type=int, default=512, metavar="N", help="pixels a side")
    parser.add_argument("--grid", action="store_true", help="draw polar angles and azimuths over a .png")
    options.add_scaling(parser)
    parser.add_argument("--exposure", type=options.number, help="factor on the linear values of a .png")


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Write the map."""
    from ..evaluate.disc_map import brdf_map, exposure_of, save_map
    from ..files.images import check_image_path
    from ..table.table import SpectralTable

    check_image_path(args.out)
    table = SpectralTable.load(args.table)
    illuminant = table.light
    seen, note = options.scaled(args, table)
    xyz = brdf_map(seen, options.direction([args.theta_i, args.phi_i]), args.size)
    exposure = exposure_of(xyz, illuminant) if args.exposure is None else args.exposure
    path = save_map(xyz, args.out, exposure, illuminant, args.grid)
    return {
        "out": str(path),
        "size": args.size,
        "y_max": float(xyz[..., 1].max()),
        "exposure": exposure,
        **table.stuff,
        **note,
    }
