# SPDX-License-Identifier: GPL-3.0-or-later
"""Every way of the thesis from heights to T(u, v, w), by name, with one interface.

========== ============================================================== ===========================
name       what it does                                                   thesis
========== ============================================================== ===========================
direct     sums over the pixels, no series: the reference                 eq. 3.23
windowed   terms of a series, convolved with the window's transform       eq. 3.26-3.32, corrected
windowed3x3 the same with the thesis's 3 x 3 neighbours on the bins       eq. 3.29-3.32, corrected
flss       the same as the thesis's shader does it: Taylor terms in       eq. 3.32, section 4.3
           single precision, 3 x 3 neighbours
pq         a periodic surface of N1 x N2 copies of the patch, sinc        eq. 3.33-3.49, corrected
           interpolation between the bins
========== ============================================================== ===========================

Each is an object with ``transform(u, v, w, wavelength_m)`` (T in 1/sr; arrays that broadcast), ``area_m2`` (the
height of a flat patch's peak, lambda^2 T, which relates absolute and relative values, see
`precompute.evaluate.surface.relative_factor`) and ``facts`` (what it costs, for the user: terms, bound, neighbours).
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from ...bake.window import default_sigma_s
from ...errors import ParameterError
from ...scan.heightfield import HeightField
from .bins import Band

METHODS = ("direct", "windowed", "windowed3x3", "flss", "pq")


class Method(Protocol):
    """What all methods have."""

    area_m2: float
    facts: dict[str, Any]

    def transform(self, u: np.ndarray, v: np.ndarray, w: np.ndarray, wavelength_m: float) -> np.ndarray: ...


def make_method(
    name: str,
    field: HeightField,
    sigma_s_m: float | None = None,
    series: str = "chebyshev",
    tolerance: float | None = None,
    replicas: tuple[int, int] = (26, 26),
    band: Band | None = None,
) -> Method:
    """Build a method by name.

    Parameters
    ----------
    name
        One of `METHODS`.
    field
        A prepared heightfield; for ``pq`` one period of the surface.
    sigma_s_m
        Coherence width of the windowed methods; None takes sunlight's. ``pq`` has none: its
        coherence is the extent of the copies.
    series
        ``chebyshev`` or ``taylor``, for the windowed methods and ``pq``; ``flss`` is always Taylor.
    tolerance
        Largest error of p that the series may leave; None takes 1e-6 (``flss``: 1e-2).
    replicas
        Copies along x and y for ``pq``.
    band
        The part of the frequency plane that will be asked for; None for all that light can reach.

    Raises
    ------
    ParameterError
        For an unknown name, or a value that the method cannot take.
    """
    from .exact import Exact
    from .flss import Flss
    from .periodic import Periodic
    from .windowed import Windowed

    sigma = default_sigma_s(field, "single") if sigma_s_m is None else sigma_s_m
    error = 1e-6 if tolerance is None else tolerance
    if name == "direct":
        return Exact(field, sigma)
    if name in ("windowed", "windowed3x3"):
        return Windowed(field, sigma, series, error, truncated=name == "windowed3x3", band=band)
    if name == "flss":
        return Flss(field, sigma, 1e-2 if tolerance is None else tolerance, band=band)
    if name == "pq":
        return Periodic(field, replicas, series, error)
    raise ParameterError(f"Unknown method '{name}'; choose one of {', '.join(METHODS)}.")
