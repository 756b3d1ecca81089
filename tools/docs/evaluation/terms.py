# SPDX-License-Identifier: GPL-3.0-or-later
"""Convergence in the number of terms: errors of p, and what they do to colours."""

import math

import numpy as np

from precompute.bake.series import bessel_order, node_count, single_precision_floor, taylor_bound, taylor_order
from precompute.errors import ParameterError
from precompute.evaluate.colour_difference import delta_e_2000
from precompute.evaluate.directions import disc_directions, from_angles
from precompute.evaluate.methods import make_method
from precompute.evaluate.methods.bins import KAPPA_MAX
from precompute.evaluate.methods.flss import method_xyz
from precompute.presets import PRESETS, make_preset
from tools.docs.fill_page import table

from .common import new_figure, scans, snake

_ORDERS = np.arange(2, 41, 2)


def _taylor_error(x, order, dtype):
    """Largest error of exp(-i t) over t in [-x, x], powers and sums in the given precision."""
    t = np.linspace(-x, x, 401).astype(dtype)
    term, total = np.ones(t.shape, np.result_type(dtype, 1j)), np.ones(t.shape, np.result_type(dtype, 1j))
    for n in range(1, order + 1):
        term = term * (-1j * t / dtype(n)).astype(term.dtype)
        total = total + term
    return float(np.abs(total - np.exp(-1j * t.astype(float))).max())


def _chebyshev_error(x, order, dtype):
    """The same for the Jacobi-Anger series, kappa in [0, kappa_max] and heights up to x / kappa_max."""
    from scipy.special import jv

    half = (0.5 * np.linspace(-x, x, 201))[:, None]
    s = np.linspace(-1.0, 1.0, 101)[None, :]
    complex_type = np.result_type(dtype, 1j)
    total = np.zeros(np.broadcast_shapes(half.shape, s.shape), complex_type)
    for n in range(order + 1):
        factor = (1 if n == 0 else 2) * (-1j) ** n * jv(n, half)
        total = total + factor.astype(complex_type) * np.cos(n * np.arccos(s)).astype(dtype)
    total = total * np.exp(-1j * half).astype(complex_type)
    return float(np.abs(total - np.exp(-1j * half * (1.0 + s))).max())


def _cut(method, terms):
    """The method with its first terms only."""
    method.terms = method.terms[:terms]
    method.series.terms = len(method.terms)
    return method


def _colour_errors(field, sigma, wi, wr, reference):
    """Median Delta E 2000 over the number of terms."""
    found = {}
    for series in ("taylor", "chebyshev"):
        found[series] = []
        most = make_method("windowed3x3", field, sigma, series, 1e-7)
        terms = most.terms
        for order in _ORDERS:
            most.terms = terms
            xyz = method_xyz(_cut(most, order + 1), wi, wr, step_m=10e-9)
            found[series].append(float(np.median(delta_e_2000(xyz, reference))))
    return found


def _draw(x, name, colours, path):
    figure = new_figure(10.0, 3.9)
    left, right = figure.subplots(1, 2)
    left.semilogy(_ORDERS, [taylor_bound(x, n) for n in _ORDERS], "k:", label="Taylor, bound")
    for label, error, dtype in (
        ("Taylor, double", _taylor_error, np.float64),
        ("Taylor, single", _taylor_error, np.float32),
        ("Chebyshev, double", _chebyshev_error, np.float64),
        ("Chebyshev, single", _chebyshev_error, np.float32),
    ):
        left.semilogy(_ORDERS, [error(x, n, dtype) for n in _ORDERS], label=label)
    left.set_ylim(1e-16, 1e4)
    left.set_ylabel("largest error of p")
    left.set_title(f"{name}, kappa h = {x:.1f}", fontsize=10)
    for series, values in colours.items():
        right.semilogy(_ORDERS, np.maximum(values, 1e-6), label=series.capitalize())
    right.axhline(1.0, color="0.6", linewidth=1)
    right.set_ylabel("median Delta E 2000")
    right.set_title("colours of the snake preset", fontsize=10)
    for axis in (left, right):
        axis.set_xlabel("N, last term")
        axis.legend(fontsize=8)
        axis.grid(alpha=0.3)
    figure.savefig(path)


def _needed(half_range):
    """Cells: last term at 1e-4 of Taylor (or what is in its way) and Chebyshev, and nodes of kappa."""
    x = KAPPA_MAX * half_range
    try:
        taylor = str(taylor_order(x, 1e-4))
    except ParameterError:
        taylor = "refused"
    single = single_precision_floor("taylor", x)
    chebyshev = bessel_order(0.5 * x, 1e-4)
    return [f"{x:.1f}", taylor, f"{single:.0e}", chebyshev, node_count(x, 1e-4)]


def run(pictures):
    """Blocks `bound`, `needed terms`, `terms and colours`."""
    x = 1.5 * math.pi
    bound = [[n, f"{taylor_bound(x, n):.3e}", f"{_taylor_error(x, n, np.float64):.3e}"] for n in (20, 25, 30)]
    rows = []
    for name, preset in PRESETS.items():
        if name != "flat":
            rows.append([preset.label, *_needed(0.5 * np.ptp(make_preset(name).heights))])
    for name, field in scans().items():
        rows.append([name, *_needed(0.5 * np.ptp(field.heights))])
    field, sigma = snake(20.0, 256), 2e-6
    wi = from_angles(np.radians(20.0), np.radians(225.0))
    directions, inside = disc_directions(24)
    wr = directions[inside]
    reference = method_xyz(make_method("windowed3x3", field, sigma, "chebyshev", 1e-9), wi, wr, step_m=10e-9)
    colours = _colour_errors(field, sigma, wi, wr, reference)
    x = KAPPA_MAX * 0.5 * np.ptp(field.heights)
    _draw(x, "snake preset", colours, pictures / "evaluation_terms.png")
    visible = [
        [series.capitalize(), next((n for n, e in zip(_ORDERS, values, strict=True) if e < 1.0), "-"),
         next((n for n, e in zip(_ORDERS, values, strict=True) if e < 0.01), "-")]
        for series, values in colours.items()
    ]  # fmt: skip
    print("terms", flush=True)
    return {
        "bound": table(["N", "bound", "largest error"], bound),
        "needed terms": table(
            ["", "kappa h", "Taylor, N", "Taylor's error in single precision", "Chebyshev, N", "nodes of kappa"], rows
        ),
        "terms and colours": table(["series", "Delta E below 1 from N", "below 0.01 from N"], visible),
    }
