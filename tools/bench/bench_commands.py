# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure how long the command line takes from its start to its end, over `python -c "import numpy"`.

`bench_commands.py [--rounds N]`

A BRDF map of 512 x 512 pixels of the preset snake, what a scan holds, and the help, by both states of the code in turn.
Merged into out/bench.json under "commands".
"""

import argparse
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools.bench.machine import Spread, warn_if_busy  # noqa: E402
from tools.bench.results import merge  # noqa: E402
from tools.bench.states import BEFORE, code_before, seconds_of  # noqa: E402  (a script: the path comes first)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rounds", type=int, default=9)
    rounds = parser.parse_args().rounds
    roots = {"now": ROOT, "before": code_before()}
    roots = {name: root for name, root in roots.items() if root is not None}
    seconds = {}
    with tempfile.TemporaryDirectory() as folder:
        scan, picture = Path(folder, "snake.gsf"), Path(folder, "map.png")
        for name, root in roots.items():  # each state reads the tables of its own format
            seconds_of(root, "-m", "precompute", "preset", "snake", "--out", scan)
            seconds_of(root, "-m", "precompute", "bake", scan, "--out", Path(folder, name))
        commands = {
            "map": ["map", "TABLE", "--theta-i", 30, "--phi-i", 0, "--out", picture],
            "info": ["info", scan],
            "--help": ["--help"],
        }
        for number in range(-1, rounds):  # the first round compiles
            row = [("numpy", seconds_of(ROOT, "-c", "import numpy"))]
            for label, words in commands.items():
                for name, root in roots.items():
                    table = Path(folder, name, "snake.exr")
                    given = [table if word == "TABLE" else word for word in words]
                    row.append((f"{label}, {name}", seconds_of(root, "-m", "precompute", *given)))
            for label, taken in row if number >= 0 else ():
                seconds.setdefault(label, []).append(taken)
    numpy = seconds.pop("numpy")
    print(f"command line over python -c 'import numpy' ({Spread(numpy)}), {rounds} rounds; before: {BEFORE}")
    numbers = {"import_numpy": Spread(numpy).to_json()}
    for label, each in seconds.items():
        over = Spread([taken / base for taken, base in zip(each, numpy, strict=True)])
        print(f"  {label:<16} {Spread(each)!s:<22} {over.median:5.1f} times", flush=True)
        numbers[label] = {**Spread(each).to_json(), "over_numpy": over.to_json()}
    merge("commands", {**numbers, "quiet": warn_if_busy()})


if __name__ == "__main__":
    main()
