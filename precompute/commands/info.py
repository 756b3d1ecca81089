# SPDX-License-Identifier: GPL-3.0-or-later
"""Say what a scan or a table holds: shape, size, heights, channel; terms, energy."""

from __future__ import annotations

import argparse
from typing import Any

from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILE, its units and the part to look at."""
    options.add_scan(parser)
    options.add_crop(parser)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """See `precompute.scan.info.scan_info` and `precompute.table.facts.table_facts`.

    Of a scan also the default coherence window of each ensemble, and what limits it.
    """
    from ..table.facts import is_table, table_facts

    if is_table(args.file):
        return table_facts(args.file)
    from ..bake.window import coherence
    from ..scan.clipping import crop
    from ..scan.info import scan_info

    field, wanted = options.read(args), options.crop(args)
    if wanted is not None and "cropped_m" not in field.metadata:
        field = crop(field, wanted[:2], wanted[2:])
    windows = {name: coherence(field, name, None).to_json() for name in ("average", "single")}
    return {**scan_info(field), "coherence": windows}


def describe(result: dict[str, Any]) -> str:
    """In micrometres and nanometres."""
    if "table" in result:
        return _of_table(result)
    rows, cols = result["shape"]
    x, y = (1e6 * side for side in result["size_m"])
    low, high, rms = (1e9 * result[key] for key in ("z_min_m", "z_max_m", "rms_m"))
    return "\n".join(
        (
            f"{result['format']}, channel {result['channel']}",
            f"{cols} x {rows} pixels, {x:.6g} um x {y:.6g} um",
            f"heights {low:.6g} to {high:.6g} nm, rms {rms:.6g} nm",
            f"{result['missing']} missing points",
            *(
                f"coherence {name} {1e6 * window['sigma_s_m']:.4g} um ({window['limit']})"
                for name, window in result["coherence"].items()
            ),
        )
    )


def _of_table(result: dict[str, Any]) -> str:
    from ..table.facts import energy_lines, lookup_lines

    lines = [f"table of format {result['format_version']}, {result['texels'][0]} x {result['texels'][1]} texels"]
    if result["scan"]:
        size = result["size_m"]
        lines.append(f"of {result['scan']}" + (f", {1e6 * size[0]:.6g} um x {1e6 * size[1]:.6g} um" if size else ""))
    lines += [f"{result['terms']} terms", f"albedo at most {result['albedo_max']:.3f}"]
    return "\n".join([*lines, *(f"energy, {line}" for line in energy_lines(result)), *lookup_lines(result)])
