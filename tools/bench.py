# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure a bake: time of each stage, memory, size, and the error of the table against the reference evaluator.

`bench.py [--scan FILE [--size-um X Y] [--height-nm H]] [--ensemble average|single] [--sigma-s-um S] [--directions N]`

Without `--scan` it takes the Xenopeltis scan of the folder DIFFRACTION_SCAN_DIR (default ../shared/data), or the preset
snake where there is none. Directions are random: both polar angles uniform in 0-70 deg, any azimuth, seed 1.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
XENOPELTIS = "xenopeltis_65um_818.69nm.png"


def precompute(*arguments):
    """Run `python -m precompute ... --json` in a process of its own and return what it printed.

    Parameters
    ----------
    *arguments : str
        Of the command line.

    Returns
    -------
    dict
    """
    command = [sys.executable, "-m", "precompute", *map(str, arguments), "--json"]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        sys.exit(done.returncode)
    return json.loads(done.stdout)


def scan_to_measure(arguments, folder):
    """The scan's path and the options that go with it."""
    if arguments.scan:
        options = ["--size-um", *arguments.size_um] if arguments.size_um else []
        options += ["--height-nm", arguments.height_nm] if arguments.height_nm else []
        return Path(arguments.scan).resolve(), options
    scans = Path(os.environ.get("DIFFRACTION_SCAN_DIR", ROOT.parent / "shared" / "data"))
    if (scans / XENOPELTIS).is_file():
        return scans / XENOPELTIS, ["--size-um", 65, 65, "--height-nm", 818.69]
    path = folder / "snake.gsf"
    precompute("preset", "snake", "--out", path)
    return path, []


def directions(count, seed=1):
    """Random pairs of directions.

    Returns
    -------
    wi, wr : ndarray, shape (count, 2)
        Polar angle and azimuth in degrees.
    """
    random = np.random.default_rng(seed)
    pairs = random.uniform(size=(2, count, 2)) * [70.0, 360.0]
    return pairs[0], pairs[1]


def report_bake(baked):
    """Print what a bake cost."""
    for stage, seconds in baked["seconds"].items():
        print(f"  {stage:<20} {seconds:8.2f} s")
    print(f"  {'texels':<20} {baked['bytes'] / 1e6:8.1f} MB")
    print(f"  {'peak memory':<20} {baked['peak_rss_bytes'] / 1e6:8.0f} MB")
    print(f"  {'terms':<20} {baked['terms']:8d}")


def report_errors(table, scan, options, count):
    """Print the relative error of Y at random directions, and the time of one evaluation of the reference."""
    errors, start = [], time.perf_counter()
    for wi, wr in zip(*directions(count), strict=True):
        pair = ["--wi", *wi, "--wr", *wr]
        reference = precompute("direct", scan, *options, *pair)["xyz"][1]
        errors.append(abs(precompute("eval", table, *pair)["xyz"][1] / reference - 1.0))
    seconds = (time.perf_counter() - start) / count
    median, percentile = np.percentile(errors, [50, 95])
    print(f"  error of Y at {count} directions: median {median:.3%}, 95th percentile {percentile:.3%}")
    print(f"  {seconds:.1f} s for each reference value")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan")
    parser.add_argument("--size-um", nargs=2)
    parser.add_argument("--height-nm")
    parser.add_argument("--ensemble", default="average", choices=["average", "single"])
    parser.add_argument("--series", default="nodes", choices=["nodes", "chebyshev", "taylor"])
    parser.add_argument("--sigma-s-um")
    parser.add_argument("--directions", type=int, default=8)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as scratch:
        scan, reading = scan_to_measure(arguments, Path(scratch))
        options = [*reading, "--level", "poly2", "--clip", "99.9", "--ensemble", arguments.ensemble]
        options += ["--series", arguments.series]
        if arguments.sigma_s_um:
            options += ["--sigma-s-um", arguments.sigma_s_um]
        print(f"{scan.name}, {arguments.ensemble}, {arguments.series}")
        baked = precompute("bake", scan, "--out", scratch, *options)
        report_bake(baked)
        if arguments.directions:
            report_errors(baked["table"], scan, options, arguments.directions)


if __name__ == "__main__":
    main()
