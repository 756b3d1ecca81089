# SPDX-License-Identifier: GPL-3.0-or-later
"""What this machine can do, to hold a measured time against, and whether it is quiet enough to measure on.

`machine.py` prints the yardsticks: plain transforms, memory bandwidth, products of matrices.
"""

import os
import platform
import statistics
import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

#: Part of the processors that others may take, and spread of a yardstick, on a machine that is called quiet.
BUSY, SPREAD = 0.05, 0.10

#: Side of the transform, bytes of the copy and side of the matrices of the yardsticks.
FFT_SIDE, COPY_BYTES, MATRIX_SIDE = 2048, 2**28, 2048


class Spread:
    """Seconds of several rounds: their median, and how far they reach."""

    def __init__(self, seconds):
        self.seconds = sorted(seconds)
        self.median = statistics.median(self.seconds)

    @property
    def width(self):
        """From the second smallest to the second largest (of five rounds or more), over the median."""
        inner = self.seconds[1:-1] if len(self.seconds) >= 5 else self.seconds
        return (inner[-1] - inner[0]) / self.median

    def __str__(self):
        return f"{self.median:.3g} s (+-{50 * self.width:.0f} %)"

    def to_json(self):
        return {"median": self.median, "least": self.seconds[0], "most": self.seconds[-1], "rounds": len(self.seconds)}


def _timed(work, rounds):
    work()
    seconds = []
    for _ in range(rounds):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return Spread(seconds)


def yardsticks(rounds=5):
    """Measure the machine with all processors that this process may use.

    Returns
    -------
    dict
        ``fft``: `Spread` of a complex single-precision transform of 2048 x 2048; ``copy``: `Spread` of copying 256 MB;
        ``gigabytes_per_second`` read and written by that copy; ``product``: `Spread` of a single-precision product of
        2048 x 2048; ``gigaflops`` of it.
    """
    from scipy.fft import fft2

    from precompute.bake.transforms import workers

    values = np.ones((FFT_SIDE, FFT_SIDE), np.complex64)
    fft = _timed(lambda: fft2(values, workers=workers()), rounds)
    source, target = (np.ones(COPY_BYTES // 4, np.float32) for _ in range(2))
    copy = _timed(lambda: np.copyto(target, source), rounds)
    matrix = np.ones((MATRIX_SIDE, MATRIX_SIDE), np.float32)
    product = _timed(lambda: matrix @ matrix, rounds)
    return {
        "fft": fft,
        "copy": copy,
        "gigabytes_per_second": 2e-9 * COPY_BYTES / copy.median,
        "product": product,
        "gigaflops": 2e-9 * MATRIX_SIDE**3 / product.median,
    }


def taken_by_others(seconds=1.0):
    """Part of all processors' time that other processes take while this one sleeps; None where it cannot be read."""

    def read():
        # user nice system idle iowait irq softirq steal
        return [int(x) for x in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]

    try:
        before = read()
        time.sleep(seconds)
        spent = [after - was for after, was in zip(read(), before, strict=True)]
    except OSError:
        return None
    idle = spent[3] + spent[4]
    return 1.0 - idle / max(sum(spent), 1)


def warn_if_busy(found=None):
    """Say so on standard output where the machine is not quiet.

    Parameters
    ----------
    found : dict, optional
        `yardsticks`, whose spread counts too.

    Returns
    -------
    bool
        Whether it is quiet.
    """
    others = taken_by_others()
    reasons = []
    if others is not None and others > BUSY:
        reasons.append(f"other processes take {100 * others:.0f} % of the processors")
    for name in ("fft", "copy", "product") if found else ():
        if found[name].width > SPREAD:
            reasons.append(f"the yardstick '{name}' varies by {100 * found[name].width:.0f} %")
    if reasons:
        print(f"WARNING: this machine is not quiet: {', '.join(reasons)}. The numbers are worth little.", flush=True)
    return not reasons


def describe(found):
    """The machine and its yardsticks in two lines, and the same for JSON."""
    name = processor()
    print(f"{name}, {os.cpu_count()} processors, Python {platform.python_version()}, numpy {np.__version__}")
    speed, products = found["gigabytes_per_second"], found["gigaflops"]
    print(
        f"  yardsticks: fft2 of {FFT_SIDE} x {FFT_SIDE} complex64 {found['fft']}, copy {speed:.1f} GB/s,"
        f" products {products:.0f} Gflop/s",
        flush=True,
    )
    return {
        "processor": name,
        "processors": os.cpu_count(),
        "fft2_seconds": found["fft"].to_json(),
        "gigabytes_per_second": found["gigabytes_per_second"],
        "gigaflops": found["gigaflops"],
    }


def processor():
    """The processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def main():
    from tools.bench.results import merge

    found = yardsticks()
    merge("machine", {**describe(found), "quiet": warn_if_busy(found)})


if __name__ == "__main__":
    main()
