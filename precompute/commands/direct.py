# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluate the BRDF of a scan without a table: by direct summation, the reference, or by another method."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

import numpy as np

from ..evaluate.methods import METHODS
from ..parameters import BakeParameters
from . import options
from .method_facts import method_lines


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILE, the options of bake, two directions and perhaps one wavelength."""
    options.add_scan(parser)
    options.add_parameters(parser)
    options.add_replicas(parser)
    options.add_stuff(parser)
    options.add_directions(parser)
    parser.add_argument("--wavelength-nm", type=options.number, metavar="L", help="one wavelength instead of XYZ")
    parser.add_argument("--step-nm", type=options.number, metavar="D", help="step of the wavelength integral")
    parser.add_argument("--method", choices=METHODS, default="direct", help="how T is computed")
    parser.add_argument("--normalisation", choices=("absolute", "relative"), default="absolute")


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Absolute BRDF in 1/sr, R = 1 unless there is a substrate: ``f`` at one wavelength, else ``xyz``."""
    from ..bake.window import coherence
    from ..evaluate.direct import direct_f, direct_xyz
    from ..scan.preparation import prepare

    if args.method != "direct":
        # The series is the method's, which bakes of a stack have not.
        return _by_method(args, options.bake_parameters(argparse.Namespace(**{**vars(args), "series": "nodes"})))
    parameters = options.bake_parameters(args)
    stuff: dict[str, Any] = {"stack": parameters.stack, "lacquer": parameters.lacquer}
    said = options.said_stuff(parameters)
    patch = prepare(options.read(args), parameters)
    window = coherence(patch, parameters.ensemble, parameters.sigma_s_m)
    sigma = window.sigma_s_m
    if window.warning:
        said = {**said, "notes": [*said.get("notes", []), window.warning]}
    wi, wr = options.direction(args.wi), options.direction(args.wr)
    if args.wavelength_nm is not None:
        f = direct_f(
            patch,
            sigma,
            parameters.ensemble,
            wi,
            wr,
            args.wavelength_nm * 1e-9,
            normalisation=args.normalisation,
            **stuff,
        )
        return {"f": float(f), **said}
    step = None if args.step_nm is None else args.step_nm * 1e-9
    xyz = direct_xyz(
        patch, sigma, parameters.ensemble, wi, wr, parameters.illuminant, step, args.normalisation, **stuff
    )
    return {"xyz": np.asarray(xyz).tolist(), **said}


def _by_method(args: argparse.Namespace, parameters: BakeParameters) -> dict[str, Any]:
    """The same by a method with one coherence window, or by copies of the scan (pq)."""
    from ..errors import ParameterError
    from ..evaluate.direct import check_wavelength
    from ..evaluate.directions import uvw
    from ..evaluate.methods import make_method
    from ..evaluate.methods.flss import STEP_M, method_xyz
    from ..evaluate.surface import cos_half, geometry_factor, relative_factor
    from ..scan.preparation import prepare

    if parameters.lacquer is not None:
        raise ParameterError(f"The method '{args.method}' knows no lacquer; leave --method or --lacquer out.")
    if parameters.ensemble != "single" and args.method != "pq":
        raise ParameterError(f"The method '{args.method}' has one coherence window; add --ensemble single.")
    patch = prepare(options.read(args), replace(parameters, ensemble="single"))
    series = "chebyshev" if args.series == "nodes" else args.series
    tolerance = None if args.method == "flss" else parameters.tolerance
    made = make_method(args.method, patch, parameters.sigma_s_m, series, tolerance, tuple(args.replicas))
    wi, wr = options.direction(args.wi), options.direction(args.wr)
    if args.wavelength_nm is None:
        step = STEP_M if args.step_nm is None else args.step_nm * 1e-9
        xyz = method_xyz(made, wi, wr, parameters.illuminant, step, args.normalisation, parameters.stack)
        return {"xyz": xyz.tolist(), **options.said_stuff(parameters), **made.facts}
    wavelength = check_wavelength(args.wavelength_nm * 1e-9)
    factor = float(geometry_factor(wi, wr))
    f = factor * float(made.transform(*uvw(wi, wr), wavelength)) if factor > 0 else 0.0
    if args.normalisation == "relative":
        f *= float(relative_factor(wi, wr, wavelength, made.area_m2))
    if parameters.stack is not None:
        f *= float(parameters.stack.reflectance(np.array([wavelength]), cos_half(wi, wr))[0])
    return {"f": f, **options.said_stuff(parameters), **made.facts}


def describe(result: dict[str, Any]) -> str:
    """The value, and what a method took for it."""
    value = f"f  {result['f']:.6g}" if "f" in result else "XYZ  " + "  ".join(f"{x:.6g}" for x in result["xyz"])
    return "\n".join([value, *options.stuff_lines(result), *method_lines(result)])
