# SPDX-License-Identifier: GPL-3.0-or-later
"""What is measured, each in a process of its own: `tasks.py NAME JSON`, with the code to be measured on PYTHONPATH.

The functions use only what both this checkout and the older state have, and print one JSON object.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

#: Transforms of the thesis's precomputation.
THESIS_TERMS = 40

#: How the scan is prepared.
PREPARED = {"level": "poly2", "clip_percent": 99.9}


def peak_bytes():
    """Largest memory of this process so far; None where the system does not tell."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return None
    return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM:"))


def bake(scan, reading, out):
    """Two bakes of a file at default quality: in a fresh process, with our imports, and again."""
    start = time.perf_counter()
    from precompute.bake import bake_file
    from precompute.parameters import BakeParameters

    report = bake_file(scan, out, BakeParameters(**PREPARED), **reading)
    first = time.perf_counter() - start
    peak = peak_bytes()
    start = time.perf_counter()
    again = bake_file(scan, out, BakeParameters(**PREPARED), **reading)
    second = time.perf_counter() - start
    return {
        "first": first,
        "second": second,
        "stages": again.seconds,
        "table": str(report.path),
        "nodes": report.table.info["terms"],
        "bytes": report.table.layout.texel_bytes,
        "peak_bytes": peak,
    }


def thesis(scan, reading):
    """The thesis's precomputation of the same file: 40 complex-double ifft2 of (i h)^n, each rescaled to 8 bit."""
    from precompute.readers import read_scan

    start = time.perf_counter()
    heights = read_scan(scan, **reading).heights
    heights = (heights - heights.mean()) / np.ptp(heights)
    power = np.ones(heights.shape, np.complex128)
    kept = []
    for _ in range(THESIS_TERMS):
        transform = np.fft.ifft2(power)
        for part in (transform.real, transform.imag):
            low, high = part.min(), part.max()
            kept.append(np.rint((part - low) * (255.0 / max(high - low, 1e-300))).astype(np.uint8))
        power *= 1j * heights
    return {"seconds": time.perf_counter() - start, "images": len(kept)}


def ffts(scan, reading, nodes):
    """Only the transforms that a bake's nodes need, full size and nothing around them."""
    from scipy.fft import fft2, irfft2, rfft2

    from precompute.bake.transforms import Axis, workers
    from precompute.readers import read_scan

    field = read_scan(scan, **reading)
    sigma_s = min(field.size_m) / 10.0
    rows, cols = field.shape
    x, y = Axis.plan(cols, field.dx, sigma_s), Axis.plan(rows, field.dy, sigma_s)
    p = np.ones((y.padded, x.padded), np.complex64)
    power = np.ones((y.band, x.band), np.float32)
    lags = np.ones((y.fine, x.fine // 2 + 1), np.complex64)
    threads = workers()
    start = time.perf_counter()
    for _ in range(nodes):
        fft2(p, workers=threads)
        rfft2(power, workers=threads)
        irfft2(lags, workers=threads)
    return {"seconds": time.perf_counter() - start}


def error(scan, reading, table, directions):
    """Relative error of Y against the reference evaluator; polar angles of light and view uniform in 0-70 degrees."""
    from precompute.evaluate import brdf, direct_xyz
    from precompute.parameters import BakeParameters
    from precompute.readers import read_scan
    from precompute.scan import prepare
    from precompute.table import SpectralTable

    loaded = SpectralTable.load(table)
    patch = prepare(read_scan(scan, **reading), BakeParameters(**PREPARED))
    random = np.random.default_rng(1)
    theta, phi = np.radians(random.uniform(size=(2, 2, directions)) * np.array([70.0, 360.0])[:, None, None])
    wi, wr = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    reference = direct_xyz(patch, loaded.info["parameters"]["sigma_s_m"], "average", wi, wr)[:, 1]
    errors = np.abs(brdf(loaded, wi, wr)[:, 1] / reference - 1.0)
    return {"median_error": float(np.median(errors)), "p95_error": float(np.percentile(errors, 95))}


def rough(pixels, sigma_s_m=None):
    """A whole bake of a rough surface of ``pixels`` a side, 60 nm apart, after a small one that loads the libraries."""
    from precompute.bake import bake as whole_bake
    from precompute.parameters import BakeParameters

    try:
        from precompute.scan import HeightField
    except ImportError:
        from precompute.heightfield import HeightField

    random = np.random.default_rng(pixels)
    whole_bake(HeightField(random.normal(0.0, 1e-9, (64, 64)), 60e-9, 60e-9), BakeParameters(detail=0.2))
    # Smoothed by a Gaussian of 6 pixels, by its transform: both states of the code bake the same heights.
    frequencies = [np.fft.fftfreq(pixels), np.fft.rfftfreq(pixels)]
    lowpass = [np.exp(-2.0 * (np.pi * 6.0 * f) ** 2).astype(np.float32) for f in frequencies]
    noise = np.fft.rfft2(random.normal(size=(pixels, pixels)).astype(np.float32))
    heights = np.fft.irfft2(noise * np.outer(*lowpass), (pixels, pixels))
    field = HeightField(np.clip(heights * (50e-9 / heights.std()), -150e-9, 150e-9), 60e-9, 60e-9)
    del noise, heights
    before = peak_bytes()
    start = time.perf_counter()
    table = whole_bake(field, BakeParameters(sigma_s_m=sigma_s_m))
    return {
        "seconds": time.perf_counter() - start,
        "bytes_before": before,
        "peak_bytes": peak_bytes(),
        "texel_bytes": table.layout.texel_bytes,
    }


TASKS = {each.__name__: each for each in (bake, thesis, ffts, error, rough)}

if __name__ == "__main__":
    print(json.dumps(TASKS[sys.argv[1]](**json.loads(sys.argv[2]))))
