# SPDX-License-Identifier: GPL-3.0-or-later
"""How fine a table must be for its scan: sizes follow the coherence lobe and the height range."""

from __future__ import annotations

import math

from ..constants import W_MAX, WAVELENGTH_MIN_M
from ..table.layout import R_MAX, TableLayout, near_square_columns

#: Wavelength that sets the width of the coherence lobe in (u, v).
_REFERENCE_M = 500e-9

#: Radial step near r = 0, in lobe widths, at most and for an error of lookups of 1: on the flanks of the specular lobe,
#: which every surface has, the error goes with the square of the step. The rest is found out from the intensities.
_STEP_NEAR_ZERO, _STEP_FOR_ERROR = 0.35, 1.66

#: Ratio of neighbouring radii far out, less 1: the colour matching functions smear over several times this.
_STEP_FAR_OUT = 0.026

#: Arc between neighbouring angles at r = 1, in lobe widths. One window gives fully developed
#: speckle, the average hardly any, so ``single`` needs finer angles.
_ARC = {"average": 0.85, "single": 0.45, "periodic": 0.45}

#: Smallest |w| with a slice of its own: light and viewer both at 87 degrees.
_W_MIN = 0.1

#: |w| where the slices turn from even to a constant ratio.
_W0 = 0.4


def plan_layout(
    sigma_s_m: float,
    ensemble: str,
    half_range_m: float,
    detail: float = 1.0,
    index: float = 1.0,
    n_reflectance: int = 0,
    headroom: tuple[float, float] = (1.0, 1.0),
    error: float = 1.0,
) -> TableLayout:
    """Layout for a coherence window and a range of heights.

    Parameters
    ----------
    sigma_s_m
        Coherence window, metres.
    ensemble
        ``average``, ``single`` or ``periodic``.
    half_range_m
        Half of the range of heights, metres; deep reliefs change faster with w.
    detail
        Resolution relative to the default.
    index
        Refractive index of what lies over the relief. Under a lacquer light runs steeply: |w| lies between
        ``2 sqrt(n^2 - 1)`` and ``2 n``.
    n_reflectance
        Columns of the row that holds the reflectance of the surface's stuff; 0 without.
    headroom
        Largest Scale and Depth of a painted surface.
    error
        Largest error of lookups, a fraction.
    """
    lobe = _REFERENCE_M / (2.0 * math.pi * math.sqrt(2.0) * sigma_s_m)
    ratio = _STEP_FAR_OUT / detail
    step = min(_STEP_NEAR_ZERO, _STEP_FOR_ERROR * math.sqrt(error))
    r0 = min(step * lobe / _STEP_FAR_OUT, 1.0)
    n_r = 1 + math.ceil(math.asinh(R_MAX * headroom[0] / r0) / ratio)
    n_phi = max(256, 32 * math.ceil(2.0 * math.pi * detail / (_ARC[ensemble] * lobe) / 32))
    w_max, w_min = W_MAX * index * headroom[1], max(_W_MIN, 0.999 * W_MAX * math.sqrt(index**2 - 1.0))
    if headroom != (1.0, 1.0):  # a painted surface takes other |w| than light gives
        w_min = _W_MIN
    x = 2.0 * math.pi * w_max / WAVELENGTH_MIN_M * half_range_m
    n_w = max(12, math.ceil(detail * (10.0 + x)))
    if w_min > _W_MIN:  # as dense as they would be over the whole range, at its upper end
        whole = math.asinh(w_max / _W0) - math.asinh(_W_MIN / _W0)
        n_w = max(6, 2 + math.ceil(n_w * (math.asinh(w_max / _W0) - math.asinh(w_min / _W0)) / whole))
    return TableLayout(
        n_r=n_r,
        n_phi=n_phi,
        n_w=n_w,
        r0=r0,
        w0=_W0,
        w_min=w_min,
        power=1.0,
        w_max=w_max,
        n_albedo=2,
        n_reflectance=n_reflectance,
        scale_headroom=headroom[0],
        depth_headroom=headroom[1],
        tile_columns=near_square_columns(n_r, n_phi, n_w),
    )
