# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare the peak of a diffraction order with the grating equation and estimate the period."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from ..evaluate.methods import METHODS
from . import options
from .method_facts import method_lines


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILE, the plane of incidence and the method."""
    number = options.number
    options.add_scan(parser)
    parser.add_argument("--theta-i", type=number, required=True, metavar="T", help="light's polar angle, deg")
    parser.add_argument("--from", dest="first", type=number, required=True, metavar="A", help="first view angle, deg")
    parser.add_argument("--to", dest="last", type=number, required=True, metavar="B", help="last view angle, deg")
    parser.add_argument("--step", type=number, default=0.01, metavar="D", help="step of the view angle, deg")
    parser.add_argument("--phi", type=number, metavar="P", help="azimuth of the plane of incidence, deg; 0 by default")
    parser.add_argument("--lattice", type=int, metavar="N", help="take the azimuth of the N-th lattice vector instead")
    parser.add_argument("--order", type=int, default=1, metavar="M", help="diffraction order in view")
    parser.add_argument(
        "--wavelengths-nm", nargs=3, type=number, default=(380, 780, 5), metavar=("FIRST", "LAST", "STEP")
    )
    parser.add_argument("--method", choices=METHODS, default="windowed")
    parser.add_argument("--replicas", type=int, metavar="N", help="copies of the file along each axis (pq)")
    parser.add_argument("--normalisation", choices=("absolute", "relative"), default="relative")
    parser.add_argument(
        "--period-nm", type=number, metavar="D", help="period of the grating-equation curve in the plot"
    )
    parser.add_argument("--out", metavar="PLOT", help="the plot: .png, .pdf or .svg")
    options.add_parameters(parser)
    options.add_stack(parser)
    # One window in the middle; with the thesis's methods the series is a choice of its own.
    parser.set_defaults(ensemble="single", series="chebyshev", tolerance=None)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Estimate the period; draw the plot where --out asks for it."""
    from ..errors import ParameterError
    from ..evaluate.reflectance import Plane, estimated_periods, response, steps
    from ..evaluate.reflectance_plot import check_plot_path, save_plot
    from ..parameters import BakeParameters
    from ..scan.preparation import prepare

    if args.out is not None:
        check_plot_path(args.out)
    if args.ensemble != "single" or args.series == "nodes":
        raise ParameterError("Reflectance has one coherence window and a series; use --ensemble single.")
    if args.replicas is not None and args.method != "pq":
        raise ParameterError("Copies belong to the periodic surface; add --method pq.")
    # The tolerance is the method's here; the patch is prepared as for a bake.
    bake = argparse.Namespace(**{**vars(args), "tolerance": BakeParameters().tolerance, "series": "nodes"})
    parameters = options.bake_parameters(bake)
    patch = prepare(options.read(args), parameters)
    lattice = _lattice(patch)
    if args.lattice is not None:
        if args.phi is not None:
            raise ParameterError("Give either --phi or --lattice, not both.")
        if not 1 <= args.lattice <= len(lattice):
            raise ParameterError(
                f"The scan has {len(lattice)} dominant periods; --lattice {args.lattice} is none of them."
            )
        phi = lattice[args.lattice - 1]["phi_deg"]
    else:
        phi = args.phi or 0.0
    plane = Plane(
        np.radians(args.theta_i),
        np.radians(steps(args.first, args.last, args.step)),
        steps(*args.wavelengths_nm) * 1e-9,
        np.radians(phi),
        args.order,
    )
    replicas = 26 if args.replicas is None else args.replicas
    with options.Progress() as progress:
        values, facts = response(
            patch,
            plane,
            args.method,
            args.normalisation,
            progress,
            parameters.stack,
            sigma_s_m=None if args.sigma_s_um is None else args.sigma_s_um * 1e-6,
            series=args.series,
            tolerance=args.tolerance,
            replicas=(replicas, replicas),
        )
    peaks, periods = estimated_periods(plane, values)
    nm = periods * 1e9
    result = {
        "mean_nm": float(nm.mean()),
        "variance_nm2": float(nm.var()),
        "method": args.method,
        **facts,
        **options.said_stuff(parameters),
        "phi_deg": phi,
        "lattice": lattice,
        "curve": [
            {"wavelength_nm": float(lam * 1e9), "theta_r_deg": float(np.degrees(theta)), "period_nm": float(d)}
            for lam, theta, d in zip(plane.wavelengths_m, peaks, nm, strict=True)
        ],
    }  # fmt: skip
    if args.out is not None:
        title = f"{args.method}, light at {args.theta_i:g} deg: d = {nm.mean():.2f} nm, variance {nm.var():.3g} nm2"
        if parameters.stack is not None:
            title += f", R of {parameters.stack}"
        result["out"] = str(
            save_plot(args.out, plane, values, peaks, _curve_period(args, phi, lattice, periods), title)
        )
    return result


def _curve_period(args: argparse.Namespace, phi: float, lattice: list[dict[str, float]], periods: np.ndarray) -> float:
    """Period of the grating-equation curve in metres: the user's, the lattice's along phi, else the median estimate."""
    if args.period_nm is not None:
        return args.period_nm * 1e-9
    along = [v["spacing_nm"] * 1e-9 for v in lattice if abs((v["phi_deg"] - phi + 90.0) % 180.0 - 90.0) < 2.0]
    return along[0] if along else float(np.median(periods))


def _lattice(patch) -> list[dict[str, float]]:
    """Dominant periods of the heights: spacing, and the azimuth along which they repeat."""
    from ..scan.lattice import find_lattice

    if min(patch.shape) < 32:
        return []
    found = find_lattice(patch)
    angles = np.degrees(np.arctan2(found.frequencies[:, 1], found.frequencies[:, 0]))
    return [
        {"spacing_nm": float(1e9 * spacing), "phi_deg": float(angle)}
        for spacing, angle in zip(found.spacings_m, angles, strict=True)
    ]


def describe(result: dict[str, Any]) -> str:
    """The statistics, what the method cost, and the periods of the heights."""
    lines = [f"period    {result['mean_nm']:.3f} nm, variance {result['variance_nm2']:.4g} nm2", *method_lines(result)]
    lines += options.stuff_lines(result)
    lines += [
        f"lattice   {vector['spacing_nm']:.1f} nm along {vector['phi_deg']:.1f} deg" for vector in result["lattice"]
    ]
    if "out" in result:
        lines.append(f"plot      {result['out']}")
    return "\n".join(lines)
