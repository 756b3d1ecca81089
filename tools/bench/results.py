# SPDX-License-Identifier: GPL-3.0-or-later
"""out/bench.json: the numbers of all benchmarks, each under its own name."""

import json
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "out" / "bench.json"


def merge(name, numbers, path=RESULTS):
    """Put one benchmark's numbers beside those of the others.

    Parameters
    ----------
    name : str
        Of the benchmark, the key of its object.
    numbers : dict
        Ready for JSON; replaces what an earlier run left under the name.
    """
    from precompute.files.atomic import atomic_path

    known = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    known[name] = numbers
    with atomic_path(path) as temporary:
        Path(temporary).write_text(json.dumps(known, indent=1, sort_keys=True) + "\n", encoding="utf-8")
