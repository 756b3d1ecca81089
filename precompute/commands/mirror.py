# SPDX-License-Identifier: GPL-3.0-or-later
"""Say what colour a flat mirror of some material, films on it or a lacquer over it has."""

from __future__ import annotations

import argparse
from typing import Any

from ..light.illuminant import ILLUMINANTS
from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """MATERIALS, what lies on them, and angles."""
    parser.add_argument(
        "material", nargs="*", metavar="MATERIAL", help="names, indices, n,k or files; all named ones by default"
    )
    options.add_film(parser)
    options.add_lacquer(parser)
    parser.add_argument(
        "--theta-i", nargs="+", type=options.number, default=[0.0], metavar="T", help="angles in air, deg"
    )
    parser.add_argument(
        "--illuminant", type=options.light, default="D65", metavar="NAME|FILE",
        help=f"{', '.join(ILLUMINANTS)}, or a text file of two columns: wavelength in nm, relative power",
    )  # fmt: skip
    parser.add_argument(
        "--check", action="store_true",
        help="also bake a flat plate of each and say how far its table's mirror colour is off, as Delta E 2000",
    )  # fmt: skip


def run(args: argparse.Namespace) -> dict[str, Any]:
    """XYZ (1 as white) and sRGB of each material at each angle."""
    import numpy as np

    from ..errors import ParameterError
    from ..evaluate.colour_difference import delta_e_2000
    from ..evaluate.mirror import mirror_xyz, plate_table, seen_mirror_xyz
    from ..light.colour import encode_srgb, into_gamut, luminance_row, xyz_to_rgb
    from ..parameters import BakeParameters
    from ..stack import MATERIALS, material_of, parse_stack

    lacquer = None if args.lacquer is None else material_of(args.lacquer)
    BakeParameters(lacquer=lacquer)  # says what is no lacquer
    largest = 75.0 if args.check else 90.0
    for angle in args.theta_i:
        if not 0.0 <= angle < largest + (largest < 90.0):
            raise ParameterError(f"A mirror at {angle:g} degrees is not shown; give angles from 0 to {largest:g}.")
    theta = np.radians(args.theta_i)
    bare = plate_table(None, args.illuminant, lacquer) if args.check else None
    mirrors = []
    for name in args.material or MATERIALS:
        stack = parse_stack(name, args.film)
        assert stack is not None
        xyz = mirror_xyz(stack, theta, args.illuminant, lacquer)
        srgb = np.clip(encode_srgb(into_gamut(xyz_to_rgb(xyz), luminance_row())), 0.0, 1.0)
        entry: dict[str, Any] = {
            "stack": str(stack),
            "source": stack.substrate.source,
            "notes": list(stack.notes),
            "theta_deg": list(args.theta_i),
            "xyz": xyz.tolist(),
            "srgb": srgb.tolist(),
        }
        if bare is not None:
            table = plate_table(stack, args.illuminant, lacquer)
            seen = np.array([seen_mirror_xyz(table, bare, each, args.illuminant, lacquer) for each in theta])
            entry["delta_e_2000"] = np.atleast_1d(delta_e_2000(seen, xyz, 1.0)).tolist()
        mirrors.append(entry)
    said = (
        {}
        if lacquer is None
        else {"lacquer": {"material": lacquer.to_json(), "n": BakeParameters(lacquer=lacquer).index}}
    )
    return {"mirrors": mirrors, **said}


def describe(result: dict[str, Any]) -> str:
    """A line for each material and angle."""
    lines = options.stuff_lines(result)
    width = max(len(entry["stack"]) for entry in result["mirrors"])
    for entry in result["mirrors"]:
        for number, (angle, xyz, srgb) in enumerate(zip(entry["theta_deg"], entry["xyz"], entry["srgb"], strict=True)):
            code = "#" + "".join(f"{round(255 * value):02x}" for value in srgb)
            shown = "  ".join(f"{value:.4f}" for value in xyz)
            off = f"  Delta E {entry['delta_e_2000'][number]:.2f}" if "delta_e_2000" in entry else ""
            source = "" if number else f"  {entry['source']}"
            lines.append(
                f"{entry['stack'] if not number else '':{width}}  {angle:4.0f} deg  {shown}  {code}{off}{source}"
            )
        lines += [f"{'':{width}}  {note}" for note in entry["notes"]]
    return "\n".join(lines)
