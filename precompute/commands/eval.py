# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluate the BRDF of a table for one pair of directions."""

from __future__ import annotations

import argparse
from typing import Any

from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """TABLE and two directions."""
    parser.add_argument("table", metavar="TABLE", help="the table's .exr or .json")
    options.add_directions(parser)
    options.add_scaling(parser)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Raw absolute BRDF in 1/sr, R inside where the table has a stack (else 1): XYZ under the light of the bake."""
    import numpy as np

    from ..evaluate.surface import brdf
    from ..light.colour import adaptation
    from ..table.table import SpectralTable

    loaded = SpectralTable.load(args.table)
    table, note = options.scaled(args, loaded)
    xyz = brdf(table, options.direction(args.wi), options.direction(args.wr))
    colour = table.info["colour"]
    to_adapted = adaptation(colour["illuminant"]) if colour.get("adapted") else None
    if to_adapted is not None:
        xyz = np.linalg.solve(to_adapted, xyz)
    return {"xyz": [float(value) for value in xyz], **loaded.stuff, **note}


def describe(result: dict[str, Any]) -> str:
    """One line, and what is inside."""
    line = "XYZ  " + "  ".join(f"{value:.6g}" for value in result["xyz"]) + "  1/sr"
    return "\n".join([line, *options.stuff_lines(result), *([result["note"]] if "note" in result else [])])
