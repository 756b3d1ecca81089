# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake many scans with many parameters, on one machine or several."""

from __future__ import annotations

import argparse
from typing import Any

from ..parameters import BakeParameters
from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILES, --out, where to bake, and the options of bake, each with one value or several."""
    default = BakeParameters()
    options.add_scan(parser, several=True)
    parser.add_argument("--out", required=True, metavar="DIR", help="folder of the tables; made if missing")
    options.add_parameters(parser, several=True)
    options.add_stuff(parser)
    parser.add_argument("--detail", nargs="+", type=options.number, default=default.detail)
    parser.add_argument("--error", nargs="+", type=options.number, default=100.0 * default.error, metavar="PERCENT")
    parser.add_argument("--limit-mb", type=options.number, default=default.limit_bytes / 1e6, metavar="MB")
    parser.add_argument("--scheduler", metavar="ADDRESS", help="of a dask scheduler; by default a cluster of our own")
    parser.add_argument(
        "--workers", type=int, default=2, metavar="N", help="processes of our own cluster; 0: none, one after the other"
    )
    parser.add_argument("--retries", type=int, default=3, metavar="N", help="after a worker died")
    options.add_cache(parser)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Bake what is not there yet; a failed bake does not stop the others."""
    from ..errors import DiffractionError, ParameterError
    from ..sweep import REPORT, make_tasks, sweep

    if args.workers < 0 or args.retries < 0:
        raise ParameterError("The numbers of workers and retries cannot be negative.")
    base = BakeParameters(limit_bytes=int(args.limit_mb * 1e6), **options.stuff(args))
    tasks = make_tasks(args.file, base, options.parameter_values(args), options.scan_reading(args))
    cache = options.cache(args)
    with options.Progress() as progress:
        try:
            outcomes = sweep(
                tasks,
                args.out,
                args.scheduler,
                args.workers,
                args.retries,
                None if cache is None else cache.folder,
                None if cache is None else cache.limit_bytes,
                progress,
            )
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                "Interrupted; the finished tables stay, the same command resumes with the others."
            ) from None
    failed = [outcome for outcome in outcomes if outcome.state == "failed"]
    if failed:
        raise DiffractionError(
            f"{len(failed)} of {len(outcomes)} bakes failed, the other tables are written; '{failed[0].name}':"
            f" {failed[0].error.rstrip('.')} (all in {REPORT})."
        )
    states = [outcome.state for outcome in outcomes]
    return {
        "tables": [outcome.table for outcome in outcomes],
        **options.said_stuff(base),
        **{state: states.count(state) for state in ("baked", "cached", "skipped")},
    }


def describe(result: dict[str, Any]) -> str:
    """Counts."""
    counts = ", ".join(f"{result[state]} {state}" for state in ("baked", "cached", "skipped"))
    return "\n".join([f"{len(result['tables'])} tables: {counts}", *options.stuff_lines(result)])
