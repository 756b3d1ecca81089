# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure a bake against the older code, the plain FFTs it needs, the thesis's precomputation, and over scan sizes.

`bench_bake.py [--scan FILE --size-um X Y --height-nm H] [--rounds N] [--directions N] [--largest PIXELS] [--growth]`

Without `--scan` it takes the Xenopeltis scan of the folder DIFFRACTION_SCAN_DIR (default ../shared/data), or the preset
snake where there is none. Every measurement runs in a process of its own, the compared ones in turn (A B A B ...);
numbers are medians over the rounds, with half the width of the rounds between the second least and the second largest.
Merged into out/bench.json under "machine", "bake", "large" and "growth".
"""

import argparse
import os
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools.bench.machine import Spread, describe, warn_if_busy, yardsticks  # noqa: E402
from tools.bench.results import merge  # noqa: E402
from tools.bench.states import BEFORE, code_before, task  # noqa: E402  (a script: its folder's parent is put on the path above)

XENOPELTIS = "xenopeltis_65um_818.69nm.png"

#: Sides of rough surfaces, and coherence windows in um at 1024 pixels, over which growth is measured.
SIZES = (256, 512, 1024, 2048)
WINDOWS_UM = (1.5, 3.0, 6.0, 12.0)


def find_scan(arguments, folder):
    """The scan's path and the keywords that read it."""
    if arguments.scan:
        reading = {}
        if arguments.size_um:
            reading["size_m"] = [1e-6 * x for x in arguments.size_um]
        if arguments.height_nm:
            reading["height_m"] = 1e-9 * arguments.height_nm
        return Path(arguments.scan).resolve(), reading
    scans = Path(os.environ.get("DIFFRACTION_SCAN_DIR", ROOT.parent / "shared" / "data"))
    if (scans / XENOPELTIS).is_file():
        return (scans / XENOPELTIS).resolve(), {"size_m": [65e-6, 65e-6], "height_m": 818.69e-9}
    from precompute.presets import make_preset
    from precompute.scan import write_gsf

    path = folder / "snake.gsf"
    write_gsf(make_preset("snake"), path)
    return path, {}


def ratio(one, other):
    """Of two rows of seconds, round by round."""
    return Spread([a / b for a, b in zip(one, other, strict=True)])


def show(label, spread, unit="", yardstick=None):
    """One line: the median, its spread, and how many plain transforms of the machine that is."""
    beside = "" if yardstick is None else f"   {spread.median / yardstick:7.1f} plain fft2 of this machine"
    print(f"  {label:<52} {spread.median:8.3g} {unit:<2} +-{50 * spread.width:3.0f} %{beside}", flush=True)


def measure_bake(arguments, folder, found):
    """Bakes by both states of the code, thesis's precomputation and plain transforms in turn; the error at the end."""
    scan, reading = find_scan(arguments, folder)
    given = {"scan": str(scan), "reading": reading}
    roots = {"now": ROOT, "before": code_before()}
    roots = {name: root for name, root in roots.items() if root is not None}
    baked = {name: [] for name in roots}
    thesis, ffts = [], []
    for number in range(-1, arguments.rounds):  # the first round compiles sources and fills the system's caches
        for name, root in roots.items():
            baked[name].append(task(root, "bake", **given, out=str(folder / f"{name}{number}")))
        thesis.append(task(ROOT, "thesis", **given)["seconds"])
        ffts.append(task(ROOT, "ffts", **given, nodes=baked["now"][-1]["nodes"])["seconds"])
    baked, thesis, ffts = {name: rounds[1:] for name, rounds in baked.items()}, thesis[1:], ffts[1:]
    errors = task(ROOT, "error", **given, table=baked["now"][-1]["table"], directions=arguments.directions)

    fft = found["fft"].median
    print(f"{scan.name}, {arguments.rounds} rounds; before: {BEFORE}")
    show(f"plain transforms it needs ({baked['now'][0]['nodes']} nodes)", Spread(ffts), "s", fft)
    show("the thesis's precomputation", Spread(thesis), "s", fft)
    numbers = {"scan": scan.name, "ffts": Spread(ffts).to_json(), "thesis": Spread(thesis).to_json(), **errors}
    for name, rounds in baked.items():
        first, second = ([each[which] for each in rounds] for which in ("first", "second"))
        peak = max(each["peak_bytes"] or 0 for each in rounds)
        rows = {
            "whole bake, fresh process": (Spread(first), "s"),
            "the same over the thesis's precomputation": (ratio(first, thesis), ""),
            "the same over its plain transforms": (ratio(first, ffts), ""),
            "second bake in the same process": (Spread(second), "s"),
            "the same over its plain transforms, second": (ratio(second, ffts), ""),
        }
        for label, (spread, unit) in rows.items():
            show(f"{label}, {name}", spread, unit, fft if unit else None)
        stages = {
            stage: float(np.median([each["stages"].get(stage, 0.0) for each in rounds]))
            for stage in rounds[0]["stages"]
        }
        print("    second bake: " + ", ".join(f"{stage} {seconds:.2f} s" for stage, seconds in stages.items()))
        print(f"    peak memory {peak / 1e6:.0f} MB, texels {rounds[0]['bytes'] / 1e6:.1f} MB", flush=True)
        numbers[name] = {
            **{label: spread.to_json() for label, (spread, _) in rows.items()},
            "stages": stages,
            "peak_bytes": peak,
        }
    print(
        f"  error of Y at {arguments.directions} directions: median {errors['median_error']:.3%},"
        f" 95th percentile {errors['p95_error']:.3%}",
        flush=True,
    )
    return numbers


def measure_large(pixels, rounds, found):
    """A large rough surface by both states of the code in turn."""
    roots = {"now": ROOT, "before": code_before()}
    roots = {name: root for name, root in roots.items() if root is not None}
    results = {name: [] for name in roots}
    for _ in range(rounds):
        for name, root in roots.items():
            results[name].append(task(root, "rough", pixels=pixels))
    print(f"rough surface, {pixels} x {pixels}, {rounds} rounds")
    numbers = {"pixels": pixels}
    for name, rows in results.items():
        spread = Spread([row["seconds"] for row in rows])
        peak = max(row["peak_bytes"] or 0 for row in rows)
        show(f"whole bake, {name}", spread, "s", found["fft"].median)
        print(f"    peak memory {peak / 1e9:.2f} GB, texels {rows[0]['texel_bytes'] / 1e6:.0f} MB", flush=True)
        numbers[name] = {**spread.to_json(), "peak_bytes": peak, "texel_bytes": rows[0]["texel_bytes"]}
    if len(results) == 2:
        over = ratio(*([row["seconds"] for row in results[name]] for name in ("now", "before")))
        show("now over before", over)
        numbers["now_over_before"] = over.to_json()
    return numbers


def measure_growth(rounds):
    """Whole bakes over sizes (coherence window a tenth of the side) and over coherence windows."""
    rows = {pixels: [task(ROOT, "rough", pixels=pixels) for _ in range(rounds)] for pixels in SIZES}
    medians = {pixels: float(np.median([row["seconds"] for row in each])) for pixels, each in rows.items()}
    extra = {
        pixels: float(np.median([(row["peak_bytes"] or 0) - (row["bytes_before"] or 0) for row in each]))
        for pixels, each in rows.items()
    }
    # Over the larger half: a small bake is all fixed costs, which would flatter the exponent.
    last = SIZES[-2:]
    exponents = [
        float(np.polyfit(np.log([p**2 for p in last]), np.log([values[p] for p in last]), 1)[0])
        for values in (medians, extra)
    ]
    print(f"growth with the side of the scan (60 nm pixels, sigma_s a tenth of the side), {rounds} rounds")
    for pixels in SIZES:
        print(
            f"  {pixels:5d} px  {medians[pixels]:7.2f} s  {extra[pixels] / 1e6:7.0f} MB above heights and libraries,"
            f" texels {rows[pixels][0]['texel_bytes'] / 1e6:.0f} MB"
        )
    print(f"  exponents over the pixel count: time {exponents[0]:.2f}, memory {exponents[1]:.2f}")
    windows = {
        sigma: [task(ROOT, "rough", pixels=1024, sigma_s_m=1e-6 * sigma) for _ in range(rounds)] for sigma in WINDOWS_UM
    }
    print("growth with the coherence window (1024 px)")
    for sigma, each in windows.items():
        print(
            f"  sigma_s {sigma:4.1f} um  {np.median([row['seconds'] for row in each]):7.2f} s"
            f"  texels {each[0]['texel_bytes'] / 1e6:.0f} MB"
        )
    return {
        "time_exponent": exponents[0],
        "memory_exponent": exponents[1],
        "sizes": {str(pixels): {"seconds": medians[pixels], "bytes": extra[pixels]} for pixels in SIZES},
        "sigma_s_um": {
            str(sigma): float(np.median([row["seconds"] for row in each])) for sigma, each in windows.items()
        },
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan")
    parser.add_argument("--size-um", nargs=2, type=float)
    parser.add_argument("--height-nm", type=float)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--directions", type=int, default=30)
    parser.add_argument("--largest", type=int, default=4096, help="side of the large surface; 0 leaves it out")
    parser.add_argument("--growth", action="store_true", help="also over sizes and coherence windows")
    arguments = parser.parse_args()
    found = yardsticks()
    numbers = describe(found)
    merge("machine", {**numbers, "quiet": warn_if_busy(found)})
    with tempfile.TemporaryDirectory() as folder:
        merge("bake", measure_bake(arguments, Path(folder), found))
    if arguments.largest:
        merge("large", measure_large(arguments.largest, arguments.rounds, found))
    if arguments.growth:
        merge("growth", measure_growth(arguments.rounds))
    warn_if_busy()


if __name__ == "__main__":
    main()
