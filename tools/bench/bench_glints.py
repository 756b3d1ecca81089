# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what glints by tables of single windows would cost: how many windows K, how large their tables.

`bench_glints.py [--structures NAME ...] [--sigma UM] [--directions N]`

A surface seen closer than its patch would show the speckle of single coherence windows: each cell of it one of K tables
of the ensemble ``single``. The mean over many cells is the mean of the K tables, which is to be that of all windows
(the ensemble ``average``) within 1 %. Here it is compared at pairs of directions: the transform under every window of a
surface is one convolution, ``|g * (p exp(i k (u x + v y)))|^2``; K windows are drawn from all places. The error falls
with the root of K, which gives the K for 1 %. Sizes are those that a bake plans. Merged into out/bench.json under
"glints".
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import scipy.fft

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from precompute.bake.plan import plan_layout  # noqa: E402
from precompute.evaluate.directions import from_angles, uvw  # noqa: E402
from precompute.light.colour import spectral_weights  # noqa: E402
from precompute.parameters import BakeParameters  # noqa: E402
from precompute.presets import make_preset  # noqa: E402
from tools.bench.results import merge  # noqa: E402

#: Numbers of windows whose means are compared, and wavelengths of the sum.
COUNTS, WAVELENGTHS = (1, 4, 16), 24


def intensities(field, sigma_s_m, wi, wr):
    """``(places,)`` luminance under the windows of a surface, away from its rim."""
    heights, dx, dy = field.heights, field.dx, field.dy
    rows, cols = heights.shape
    y, x = (np.arange(rows) - rows // 2) * dy, (np.arange(cols) - cols // 2) * dx
    window = np.exp(-(x[None] ** 2 + y[:, None] ** 2) / (2.0 * sigma_s_m**2)).astype(np.float32)
    window = scipy.fft.fft2(scipy.fft.ifftshift(window))
    u, v, w = uvw(wi, wr)
    grid, weights = spectral_weights(step_m=(780e-9 - 380e-9) / (WAVELENGTHS - 1))
    margin = int(3 * sigma_s_m / dx)  # a patch does not repeat
    total = np.zeros((rows, cols), np.float32)
    for wavelength, weight in zip(grid, weights[:, 1], strict=True):
        k = 2.0 * np.pi / wavelength
        phase = k * (w * heights + u * x[None] + v * y[:, None])
        spectrum = scipy.fft.fft2(np.exp(1j * phase).astype(np.complex64))
        total += weight / wavelength**2 * np.abs(scipy.fft.ifft2(spectrum * window)) ** 2
    return total[margin:-margin, margin:-margin].ravel()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--structures", nargs="+", default=["snake", "foil", "brushed_metal"])
    parser.add_argument("--sigma", type=float, default=3.0, help="coherence window, micrometres")
    parser.add_argument("--directions", type=int, default=12)
    arguments = parser.parse_args()
    random = np.random.default_rng(2)
    sigma = 1e-6 * arguments.sigma
    found = {}
    for name in arguments.structures:
        field = make_preset(name, 32 * sigma, 1024)
        means, errors = [], {count: [] for count in COUNTS}
        for _ in range(arguments.directions):
            theta, phi = np.radians(random.uniform(0, 50, 2)), random.uniform(0, 2 * np.pi, 2)
            windows = intensities(field, sigma, *from_angles(theta, phi))
            means.append(windows.mean())
            for count in COUNTS:
                draws = windows[random.integers(len(windows), size=(400, count))].mean(1)
                errors[count].append(np.abs(draws - means[-1]).mean())
        weighted = {count: float(np.sum(each) / np.sum(means)) for count, each in errors.items()}
        needed = COUNTS[-1] * (weighted[COUNTS[-1]] / 0.01) ** 2
        half_range = 0.5 * float(np.ptp(field.heights))
        goal = BakeParameters().error_goal
        sizes = {}
        for ensemble in ("average", "single"):
            for width in (sigma, 16.25e-6):
                layout = plan_layout(width, ensemble, half_range, error=goal)
                sizes[f"{ensemble} {1e6 * width:g} um"] = layout.texel_bytes / 1e6
        found[name] = {"error_by_count": weighted, "windows_for_1_percent": needed, "megabytes": sizes}
        shown = ", ".join(f"K = {count}: {100 * each:.1f} %" for count, each in weighted.items())
        print(f"{name}: {shown}; 1 % takes {needed:.0f} windows", flush=True)
        print("   one table, MB:", ", ".join(f"{key} {value:.0f}" for key, value in sizes.items()), flush=True)
    merge("glints", found)


if __name__ == "__main__":
    main()
