# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluate the BRDF of a scan by direct summation: slow and exact, the reference of every table."""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILE, the options of bake, two directions and perhaps one wavelength."""
    options.add_scan(parser)
    options.add_parameters(parser)
    options.add_replicas(parser)
    options.add_directions(parser)
    parser.add_argument("--wavelength-nm", type=options.number, metavar="L", help="one wavelength instead of XYZ")
    parser.add_argument("--step-nm", type=options.number, metavar="D", help="step of the wavelength integral")
    parser.add_argument("--normalisation", choices=("absolute", "relative"), default="absolute")


def run(args: argparse.Namespace) -> dict[str, Any]:
    """Absolute BRDF without Fresnel in 1/sr: ``f`` at one wavelength, else ``xyz``."""
    from ..direct import direct_f, direct_xyz
    from ..prepare import prepare
    from ..window import default_sigma_s

    parameters = options.bake_parameters(args)
    patch = prepare(options.read(args), parameters)
    sigma = parameters.sigma_s_m
    if sigma is None or parameters.ensemble == "periodic":
        sigma = default_sigma_s(patch, parameters.ensemble)
    wi, wr = options.direction(args.wi), options.direction(args.wr)
    if args.wavelength_nm is not None:
        f = direct_f(
            patch, sigma, parameters.ensemble, wi, wr, args.wavelength_nm * 1e-9, normalisation=args.normalisation
        )
        return {"f": float(f)}
    step = None if args.step_nm is None else args.step_nm * 1e-9
    xyz = direct_xyz(patch, sigma, parameters.ensemble, wi, wr, parameters.illuminant, step, args.normalisation)
    return {"xyz": np.asarray(xyz).tolist()}


def describe(result: dict[str, Any]) -> str:
    """One line."""
    if "f" in result:
        return f"f  {result['f']:.6g}"
    return "XYZ  " + "  ".join(f"{value:.6g}" for value in result["xyz"])
