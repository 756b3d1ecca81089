# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the heightfield of a preset structure as a .gsf file."""

from __future__ import annotations

import argparse
from typing import Any

from ..presets import PRESETS
from . import options


def _parameters() -> dict[str, Any]:
    """All presets' parameters by name; presets that share a name share its meaning and unit."""
    return {parameter.name: parameter for preset in PRESETS.values() for parameter in preset.parameters}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """NAME, --out, the patch and each preset's own parameters."""
    parser.add_argument("name", metavar="NAME", help=", ".join(PRESETS))
    parser.add_argument("--out", required=True, metavar="FILE", help="the .gsf file")
    parser.add_argument("--size-um", type=options.number, metavar="S", help="side length in micrometres")
    parser.add_argument("--pixels", type=int, metavar="N", help="pixels a side")
    for name, parameter in _parameters().items():
        users = ", ".join(p.name for p in PRESETS.values() if any(q.name == name for q in p.parameters))
        text = f"{parameter.help} ({users})".replace("%", "%%")
        if isinstance(parameter.default, bool):
            parser.add_argument(parameter.flag, dest=name, action="store_true", default=None, help=text)
        else:
            parser.add_argument(
                parameter.flag, dest=name, type=options.number, metavar=parameter.unit.upper() or "X", help=text
            )


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Build and write it."""
    from ..errors import OutputError
    from ..presets import make_preset
    from ..scan.gsf import write_gsf
    from ..scan.info import scan_info

    if not args.out.lower().endswith(".gsf"):
        raise OutputError(f"Cannot write '{args.out}': a preset is stored as .gsf; give the file that suffix.")
    given = {name: getattr(args, name) for name in _parameters() if getattr(args, name) is not None}
    size = None if args.size_um is None else args.size_um * 1e-6
    field = make_preset(args.name, size, args.pixels, **given)
    write_gsf(field, args.out)
    info = scan_info(field)
    return {"out": args.out, **{key: info[key] for key in ("shape", "size_m", "z_min_m", "z_max_m", "rms_m")}}
