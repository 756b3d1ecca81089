# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimated periods against the grating equation: the thesis's blazed grating, and real scans."""

import time

import numpy as np

from precompute.evaluate.reflectance import Plane, estimated_periods, response, steps
from precompute.evaluate.reflectance_plot import save_plot
from precompute.presets import make_preset
from precompute.scan.lattice import find_lattice
from tools.docs.fill_page import table

from .common import scans

_SIGMA = 16.25e-6

#: What direct summation gives (mean in nm, variance in nm^2), and what the thesis states.
_EXPECTED = {
    ("windowed", False): ("2499.58 / 0.416", "2499.997 / 0.377"),
    ("windowed", True): ("2500.24 / 0.184", ""),
    ("pq 26", False): ("2499.57 / 0.92", ""),
    ("pq 26", True): ("2502.36 / 0.51", "2502.43"),
    ("pq 100", False): ("2499.96 / 0.150", ""),
    ("pq 100", True): ("2500.16 / 0.152", ""),
}


def _plane():
    return Plane(np.radians(75.0), np.radians(steps(-55, -40, 0.01)), steps(380, 780, 5) * 1e-9)


def _blazed(method, mirror):
    shape = {"period_um": 2.5, "depth_nm": 250, "mirror": mirror}
    if method == "windowed":
        return make_preset("blazed", (65e-6, 2e-6), 1300, **shape), {"sigma_s_m": _SIGMA}
    copies = int(method.split()[1])
    return make_preset("blazed", 2.5e-6, 50, **shape), {"replicas": (copies, copies)}


def _grating(pictures):
    plane, rows = _plane(), []
    for (method, mirror), (direct, thesis) in _EXPECTED.items():
        field, options = _blazed(method, mirror)
        start = time.perf_counter()
        values, facts = response(field, plane, method.split()[0], **options)
        seconds = time.perf_counter() - start
        peaks, periods = estimated_periods(plane, values)
        nm = periods * 1e9
        name = method.replace("pq ", "pq, copies: ") + (", mirrored" if mirror else "")
        rows.append([name, f"{nm.mean():.2f} / {nm.var():.3f}", direct, thesis, facts["terms"], f"{seconds:.1f}"])
        if (method, mirror) == ("windowed", False):
            save_plot(pictures / "evaluation_blazed.png", plane, values, peaks, float(periods.mean()))
    head = ["method", "mean nm / variance nm2", "direct summation", "thesis", "terms", "seconds"]
    return table(head, rows)


#: Light and views (degrees) in the plane of the strongest lattice vector.
_VIEWS = {"Xenopeltis, 65 um": (60, (-46, -10, 0.1)), "Hexagonal bumps, 15 um": (75, (-20, 35, 0.1))}


def _scans(pictures):
    rows = []
    for name, field in scans().items():
        theta_i, views = _VIEWS[name]
        lattice = find_lattice(field)
        fx, fy = lattice.frequencies[0]
        phi = float(np.arctan2(fy, fx))
        plane = Plane(np.radians(theta_i), np.radians(steps(*views)), steps(400, 760, 10) * 1e-9, phi)
        values, _ = response(field, plane, tolerance=1e-4)
        peaks, periods = estimated_periods(plane, values)
        fft, found = 1e9 * lattice.spacings_m[0], 1e9 * periods
        rows.append(
            [
                name,
                f"{np.degrees(phi):.1f}",
                f"{fft:.1f}",
                f"{found.mean():.1f}",
                f"{found.std():.1f}",
                f"{100 * (found.mean() / fft - 1):+.2f} %",
            ]
        )
        if name.startswith("Xeno"):
            save_plot(pictures / "evaluation_xenopeltis.png", plane, values, peaks, float(periods.mean()))
    head = ["", "azimuth, deg", "FFT of heights, nm", "reflectance, nm", "deviation over wavelengths", "difference"]
    return table(head, rows) if rows else None


def run(pictures):
    """Blocks `grating` and, where scans are present, `scan periods`."""
    blocks = {"grating": _grating(pictures)}
    print("reflectance grating", flush=True)
    real = _scans(pictures)
    if real:
        blocks["scan periods"] = real
    return blocks
