# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake a scan into a spectral table."""

from __future__ import annotations

import argparse
from typing import Any

from ..parameters import BakeParameters
from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILE, --out and what decides the table."""
    default = BakeParameters()
    options.add_scan(parser)
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the table; made if missing")
    parser.add_argument("--name", help="name of the table's files; the scan's by default")
    options.add_parameters(parser)
    options.add_replicas(parser)
    options.add_stuff(parser)
    options.add_headroom(parser)
    parser.add_argument("--detail", type=options.number, default=default.detail, help="resolution of the table")
    parser.add_argument(
        "--error",
        type=options.number,
        default=100.0 * default.error,
        metavar="PERCENT",
        help="largest error of lookups where a value is above 1e-3 of the largest in its plane of incidence; slices,"
        " radii and angles are chosen for it",
    )
    parser.add_argument(
        "--limit-mb",
        type=options.number,
        default=default.limit_bytes / 1e6,
        metavar="MB",
        help="refuse tables with more texels than this",
    )
    parser.add_argument(
        "--memory-mb",
        type=options.number,
        metavar="MB",
        help="refuse bakes that take more than this; by default what is free",
    )
    options.add_cache(parser)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Bake and say what it cost."""
    from ..bake.baking import bake_file
    from ..files.memory import peak_rss_bytes

    parameters = options.bake_parameters(
        args, detail=args.detail, error=0.01 * args.error, limit_bytes=int(args.limit_mb * 1e6)
    )
    with options.Progress() as progress:
        cache = options.cache(args)
        memory = None if args.memory_mb is None else int(args.memory_mb * 1e6)
        reading = options.scan_reading(args)
        report = bake_file(args.file, args.out, parameters, progress, args.name, cache, memory, **reading)
    stuff = report.table.stuff
    return {
        "table": str(report.path),
        "terms": int(report.table.info["terms"]),
        "bytes": int(report.table.layout.texel_bytes),
        "seconds": {stage: round(seconds, 4) for stage, seconds in report.seconds.items()},
        "peak_rss_bytes": peak_rss_bytes(),
        "albedo_max": report.table.albedo_max,
        "energy": report.table.info["energy"],
        "error": report.table.info["error"],
        "coherence": report.table.info["coherence"],
        **stuff,
        "cache": report.cache,
        "notes": [*report.notes, *stuff.get("notes", [])],
    }


def describe(result: dict[str, Any]) -> str:
    """One line a stage."""
    from ..table.facts import energy_lines, lookup_lines

    memory = result["peak_rss_bytes"]
    lines = [
        f"table        {result['table']}",
        f"terms        {result['terms']}",
        f"texels       {result['bytes'] / 1e6:.1f} MB",
        f"peak memory  {'unknown' if memory is None else f'{memory / 1e6:.0f} MB'}",
        f"albedo       at most {result['albedo_max']:.3f}",
        *(f"energy       {line}" for line in energy_lines(result)),
        *("{:<13}{}".format(*line.split(" ", 1)) for line in lookup_lines(result)),
        f"cache        {result['cache']}",
    ]
    if "stack" in result:
        lines.insert(1, f"stack        {result['stack']}")
    if "lacquer" in result:
        lines.insert(1, f"lacquer      {result['lacquer']['material']}, n = {result['lacquer']['n']:.4f}")
    lines += [f"{stage:<14}{seconds:8.2f} s" for stage, seconds in result["seconds"].items()]
    return "\n".join(lines)
