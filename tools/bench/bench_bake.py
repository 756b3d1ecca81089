# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure a bake against the plain FFTs it needs, against the thesis's precomputation, and over scan sizes.

`bench_bake.py [--scan FILE --size-um X Y --height-nm H] [--rounds N] [--directions N] [--largest PIXELS]`

Without `--scan` it takes the Xenopeltis scan of the folder DIFFRACTION_SCAN_DIR (default ../shared/data), or the preset
snake where there is none. Every measurement runs in a process of its own, the compared ones in turn (A B A B ...); the
ratios are medians over the rounds. The results are merged into out/bench.json under "bake" and "scaling".
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

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from tools.bench.results import merge  # noqa: E402  (a script: its folder's parent is put on the path above)

XENOPELTIS = "xenopeltis_65um_818.69nm.png"

#: Transforms of the thesis's precomputation and the number of sizes a fit takes.
THESIS_TERMS = 40
SIZES = (256, 512, 1024, 2048, 4096)


def find_scan(arguments, folder):
    """The scan's path and the keywords that read it."""
    from precompute.presets import make_preset
    from precompute.scan.gsf import write_gsf

    if arguments.scan:
        reading = {}
        if arguments.size_um:
            reading["size_m"] = [1e-6 * x for x in arguments.size_um]
        if arguments.height_nm:
            reading["height_m"] = 1e-9 * arguments.height_nm
        return Path(arguments.scan).resolve(), reading
    scans = Path(os.environ.get("DIFFRACTION_SCAN_DIR", ROOT.parent / "shared" / "data"))
    if (scans / XENOPELTIS).is_file():
        return scans / XENOPELTIS, {"size_m": [65e-6, 65e-6], "height_m": 818.69e-9}
    path = folder / "snake.gsf"
    write_gsf(make_preset("snake"), path)
    return path, {}


def in_process(task, **given):
    """Run one of the tasks below in a fresh Python and return what it measured."""
    command = [sys.executable, str(Path(__file__).resolve()), "--task", task, "--given", json.dumps(given)]
    done = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout.splitlines()[-1])


def task_bake(scan, reading, out):
    """The whole bake of a file at default quality, libraries loaded on the way as in real use."""
    from precompute.bake.baking import bake_file
    from precompute.files.memory import peak_rss_bytes
    from precompute.parameters import BakeParameters

    report = bake_file(scan, out, BakeParameters(level="poly2", clip_percent=99.9), **reading)
    return {
        "seconds": report.seconds,
        "table": str(report.path),
        "nodes": report.table.info["terms"],
        "bytes": report.table.layout.texel_bytes,
        "peak_rss_bytes": peak_rss_bytes(),
    }


def task_thesis(scan, reading, out):
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


def task_ffts(scan, reading, out):
    """Only the transforms that the bake's nodes need, full size and nothing around them."""
    from scipy.fft import fft2, irfft2, rfft2

    from precompute.bake.intensity import PolarIntensity
    from precompute.bake.transforms import workers
    from precompute.bake.window import default_sigma_s
    from precompute.parameters import BakeParameters
    from precompute.readers import read_scan
    from precompute.scan.preparation import prepare

    parameters = BakeParameters(level="poly2", clip_percent=99.9)
    patch = prepare(read_scan(scan, **reading), parameters)
    polar = PolarIntensity(patch, default_sigma_s(patch, "average"), "average")
    p = np.ones((polar.y.padded, polar.x.padded), np.complex64)
    power = np.ones((polar.y.band, polar.x.band), np.float32)
    lags = np.ones((polar.y.fine, polar.x.fine // 2 + 1), np.complex64)
    threads = workers()
    start = time.perf_counter()
    for _ in range(out["nodes"]):
        fft2(p, workers=threads)
        rfft2(power, workers=threads)
        irfft2(lags, workers=threads)
    return {"seconds": time.perf_counter() - start}


def task_error(scan, reading, out):
    """Relative error of Y against the reference evaluator; polar angles of light and view uniform in 0-70 degrees."""
    from precompute.evaluate.direct import direct_xyz
    from precompute.evaluate.surface import brdf
    from precompute.parameters import BakeParameters
    from precompute.readers import read_scan
    from precompute.scan.preparation import prepare
    from precompute.table.table import SpectralTable

    table = SpectralTable.load(out["table"])
    patch = prepare(read_scan(scan, **reading), BakeParameters(level="poly2", clip_percent=99.9))
    random = np.random.default_rng(1)
    theta, phi = np.radians(random.uniform(size=(2, 2, out["directions"])) * np.array([70.0, 360.0])[:, None, None])
    wi, wr = np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)
    reference = direct_xyz(patch, table.info["parameters"]["sigma_s_m"], "average", wi, wr)[:, 1]
    errors = np.abs(brdf(table, wi, wr)[:, 1] / reference - 1.0)
    return {"median_error": float(np.median(errors)), "p95_error": float(np.percentile(errors, 95))}


def task_scaling(pixels, sigma_s_m):
    """A whole bake of a rough surface of ``pixels`` a side, 60 nm apart; memory above what the libraries take."""
    from scipy.ndimage import gaussian_filter

    from precompute.bake.baking import bake
    from precompute.files.memory import peak_rss_bytes
    from precompute.parameters import BakeParameters
    from precompute.scan.heightfield import HeightField

    random = np.random.default_rng(pixels)
    bake(HeightField(random.normal(0.0, 1e-9, (64, 64)), 60e-9, 60e-9), BakeParameters(detail=0.2))
    heights = gaussian_filter(random.normal(size=(pixels, pixels)).astype(np.float32), 6.0, mode="wrap")
    field = HeightField(np.clip(heights * (50e-9 / heights.std()), -150e-9, 150e-9), 60e-9, 60e-9)
    before = peak_rss_bytes()
    start = time.perf_counter()
    table = bake(field, BakeParameters(sigma_s_m=sigma_s_m))
    seconds = time.perf_counter() - start
    return {
        "seconds": seconds,
        "peak_bytes": peak_rss_bytes(),
        "memory_bytes": peak_rss_bytes() - before,
        "texel_bytes": table.layout.texel_bytes,
    }


TASKS = {"bake": task_bake, "thesis": task_thesis, "ffts": task_ffts, "error": task_error, "scaling": task_scaling}


def measure_bake(arguments, folder):
    """Bake, thesis's precomputation and plain transforms in turn; the error at the end."""
    scan, reading = find_scan(arguments, folder)
    given = {"scan": str(scan), "reading": reading}
    rounds = []
    for number in range(arguments.rounds):
        baked = in_process("bake", **given, out=str(folder / f"bake{number}"))
        thesis = in_process("thesis", **given, out=None)
        ffts = in_process("ffts", **given, out={"nodes": baked["nodes"]})
        rounds.append((baked, thesis["seconds"], ffts["seconds"]))
    total = np.array([baked["seconds"]["total"] for baked, _, _ in rounds])
    thesis, ffts = (np.array([entry[i] for entry in rounds]) for i in (1, 2))
    errors = in_process("error", **given, out={"table": baked["table"], "directions": arguments.directions})
    numbers = {
        "scan": scan.name,
        "seconds": {stage: float(np.median([b["seconds"][stage] for b, _, _ in rounds])) for stage in baked["seconds"]},
        "thesis_seconds": float(np.median(thesis)),
        "fft_seconds": float(np.median(ffts)),
        "over_thesis": float(np.median(total / thesis)),
        "over_ffts": float(np.median(total / ffts)),
        "texel_bytes": baked["bytes"],
        "peak_rss_bytes": baked["peak_rss_bytes"],
        **errors,
    }
    print(f"{scan.name}, whole bake in a fresh process, {arguments.rounds} rounds")
    for stage, seconds in numbers["seconds"].items():
        print(f"  {stage:<20} {seconds:8.2f} s")
    print(f"  over the plain transforms it needs ({numbers['fft_seconds']:.2f} s): {numbers['over_ffts']:.2f}")
    print(f"  over the thesis's precomputation ({numbers['thesis_seconds']:.2f} s): {numbers['over_thesis']:.2f}")
    print(f"  texels {baked['bytes'] / 1e6:.1f} MB, peak memory {baked['peak_rss_bytes'] / 1e6:.0f} MB")
    print(
        f"  error of Y at {arguments.directions} directions: median {errors['median_error']:.3%},"
        f" 95th percentile {errors['p95_error']:.3%}"
    )
    return numbers


def measure_scaling(largest):
    """Whole bakes over sizes (coherence window a tenth of the side) and over coherence windows."""
    sizes = [pixels for pixels in SIZES if pixels <= largest]
    rows = [in_process("scaling", pixels=pixels, sigma_s_m=None) for pixels in sizes]
    # Over the larger half: a small bake is all fixed costs, which would flatter the exponent.
    count = np.log(np.array(sizes[-3:], float) ** 2)
    time_exponent, memory_exponent = (
        float(np.polyfit(count, np.log([row[key] for row in rows[-3:]]), 1)[0]) for key in ("seconds", "memory_bytes")
    )
    print("scaling with the side of the scan (60 nm pixels, sigma_s a tenth of the side)")
    for pixels, row in zip(sizes, rows, strict=True):
        print(
            f"  {pixels:5d} px  {row['seconds']:7.2f} s  {row['memory_bytes'] / 1e6:7.0f} MB above the libraries,"
            f" peak {row['peak_bytes'] / 1e6:.0f} MB, texels {row['texel_bytes'] / 1e6:.0f} MB"
        )
    print(f"  exponents over the pixel count: time {time_exponent:.2f}, memory {memory_exponent:.2f}")
    windows = [1.5, 3.0, 6.0, 12.0]
    over_sigma = [in_process("scaling", pixels=1024, sigma_s_m=1e-6 * sigma) for sigma in windows]
    print("scaling with the coherence window (1024 px)")
    for sigma, row in zip(windows, over_sigma, strict=True):
        print(f"  sigma_s {sigma:4.1f} um  {row['seconds']:7.2f} s  texels {row['texel_bytes'] / 1e6:.0f} MB")
    return {
        "time_exponent": time_exponent,
        "memory_exponent": memory_exponent,
        "sizes": {str(pixels): row for pixels, row in zip(sizes, rows, strict=True)},
        "sigma_s_um": {str(sigma): row for sigma, row in zip(windows, over_sigma, strict=True)},
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scan")
    parser.add_argument("--size-um", nargs=2, type=float)
    parser.add_argument("--height-nm", type=float)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--directions", type=int, default=30)
    parser.add_argument("--largest", type=int, default=SIZES[-1])
    parser.add_argument("--task", choices=TASKS, help=argparse.SUPPRESS)
    parser.add_argument("--given", type=json.loads, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.task:
        print(json.dumps(TASKS[arguments.task](**arguments.given)))
        return
    with tempfile.TemporaryDirectory() as folder:
        merge("bake", measure_bake(arguments, Path(folder)))
    merge("scaling", measure_scaling(arguments.largest))


if __name__ == "__main__":
    main()
