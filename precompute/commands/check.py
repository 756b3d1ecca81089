# SPDX-License-Identifier: GPL-3.0-or-later
"""Say which tables are missing, damaged or of another release; exit code 1 where any is."""

from __future__ import annotations

import argparse
import contextlib
import sys
from pathlib import Path
from typing import Any


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Tables, and folders that hold some."""
    parser.add_argument("path", nargs="+", metavar="PATH", help="tables (.exr), or folders, searched with those below")


def run(args: argparse.Namespace) -> dict[str, Any]:
    """See `precompute.table.facts.fault`."""
    from ..table.facts import fault

    tables = [table for path in args.path for table in _tables(Path(path))]
    with contextlib.redirect_stdout(sys.stderr):  # OpenEXR warns of damage on standard output
        found = {str(table): fault(table) for table in tables}
    return {"tables": len(tables), "faults": {table: text for table, text in found.items() if text}}


def describe(result: dict[str, Any]) -> str:
    """A line a fault."""
    count = result["tables"]
    lines = [f"{table}: {text}" for table, text in result["faults"].items()]
    return "\n".join([*lines, f"{count} table{'s' * (count != 1)}, {len(lines)} with faults"])


def _tables(path: Path) -> list[Path]:
    if not path.is_dir():
        return [path]
    return [each.with_suffix(".exr") for each in sorted(path.rglob("*.json")) if _is_sidecar(each)]


def _is_sidecar(path: Path) -> bool:
    """Whether a JSON file is a table's, by a word that only those have; a damaged one is none."""
    try:
        return '"format_version"' in path.read_text(encoding="utf-8")
    except (OSError, ValueError):
        return False
