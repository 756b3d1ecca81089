# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory a bake will take, told before it is taken."""

from __future__ import annotations

import math

from ..constants import FREQUENCY_MAX
from ..errors import ParameterError, ScanError, SizeLimitError
from ..files.memory import available_bytes
from ..parameters import BakeParameters
from ..scan.heightfield import HeightField
from ..scan.resample import refine_factors
from ..table.albedo import SECTORS
from ..table.layout import TableLayout
from .intensity import PLANES
from .series import node_count
from .spectral_sum import RADIAL_STEP
from .transforms import Axis, lobe_width, workers

#: Libraries, and what the many small arrays take.
_BASE_BYTES = 60e6

#: Frequencies that a radius' wavelengths (380 to 780 nm) look at, on average; under lamps with lines twice as many.
_TAPS_A_RADIUS = 60


#: Scales that no optical surface leaves, metres: beyond them a unit is wrong, and numbers overflow.
_SMALLEST_SIDE, _LARGEST_SIDE = 1e-9, 1.0
_LARGEST_RELIEF = 1e-3
_SMALLEST_SIGMA, _LARGEST_SIGMA = 1e-9, 0.1


def check_scale(scan: HeightField, sigma_s_m: float) -> None:
    """Refuse sizes, heights and coherence windows that can only come from a wrong unit.

    Raises
    ------
    ScanError, ParameterError
        With the number.
    """
    if not all(_SMALLEST_SIDE <= side <= _LARGEST_SIDE for side in scan.size_m):
        x, y = scan.size_m
        raise ScanError(f"The scan is {x:.3g} m x {y:.3g} m large; check the unit of its size.")
    valid = ~scan.missing  # no copy of the heights: a large scan is checked here before anything else
    relief = float(scan.heights.max(where=valid, initial=-math.inf) - scan.heights.min(where=valid, initial=math.inf))
    if not relief <= _LARGEST_RELIEF:
        raise ScanError(f"The heights of the scan span {relief:.3g} m; check their unit.")
    if not _SMALLEST_SIGMA <= sigma_s_m <= _LARGEST_SIGMA:
        raise ParameterError(f"sigma_s is {sigma_s_m:.3g} m; give it between a nanometre and ten centimetres.")


def transform_bytes(
    field: HeightField, pixels: tuple[int, int], sigma_s_m: float, series: str, frequency_max: float = FREQUENCY_MAX
) -> float:
    """Peak while the spectra are computed, without what is kept for later.

    Parameters
    ----------
    field
        Gives the side lengths.
    pixels
        Rows and columns after refining.
    sigma_s_m
        Coherence window, metres.
    series, frequency_max
        See ``BakeParameters``.
    """
    (rows, cols), (size_x, size_y) = pixels, field.size_m
    along_x = Axis.plan(cols, size_x / cols, sigma_s_m, frequency_max)
    along_y = Axis.plan(rows, size_y / rows, sigma_s_m, frequency_max)
    # Heights and masks as read and as prepared, and a copy for the phases.
    patch = rows * cols * (2 * 9.0 + 4.0)
    # The band along x, few lags of its transform, what is interleaved, and a thread's lines.
    half = (along_y.cut + 1) * (along_x.band + along_x.fine)
    planes = 4.0 * PLANES * along_y.fine * along_x.fine
    if series == "nodes":
        spectra = 8.0 * rows * along_x.band
    else:
        # Double precision: the copy for the phases, a window, p and its parts; sums of terms for a group of kappas.
        patch += rows * cols * (4.0 + 8.0 + 3 * 16.0)
        spectra = 16.0 * (rows + 10 * along_y.band) * along_x.band
    spectra += 8.0 * half + planes + workers() * 4 * 2.0**19
    return patch + spectra


def bake_bytes(
    field: HeightField, sigma_s_m: float, layout: TableLayout, parameters: BakeParameters, angles_a_block: int
) -> float:
    """Peak of a whole bake of a prepared patch, in bytes."""
    rows, cols = field.shape
    x = parameters.kappa_max * 0.5 * float(field.heights.max() - field.heights.min())
    nodes = node_count(x, parameters.tolerance)
    along_x = Axis.plan(cols, field.dx, sigma_s_m, parameters.frequency_max)
    along_y = Axis.plan(rows, field.dy, sigma_s_m, parameters.frequency_max)
    spectra = transform_bytes(field, field.shape, sigma_s_m, parameters.series, parameters.frequency_max)
    coefficients = 4.0 * along_x.fine * along_y.fine * nodes
    texels = 12.0 * layout.n_r * layout.n_w * layout.n_phi
    frequencies = parameters.frequency_max / (RADIAL_STEP * lobe_width(sigma_s_m))
    block = angles_a_block * frequencies * (16 * 16.0 + 9.0 * nodes)
    matrices = 4.0 * layout.n_r * layout.n_w * 3 * nodes * _TAPS_A_RADIUS
    heights = rows * cols * (2 * 9.0 + (4.0 if parameters.series == "nodes" else 16.0))
    stages = (
        spectra + coefficients,
        heights + coefficients + matrices + texels + workers() * block,
        # Means of the texels over sectors and their Fourier series, and each thread's kernels, for the albedo.
        heights + texels + layout.n_r * layout.n_w * min(SECTORS, layout.n_phi) * (60.0 + 20.0 * workers()),
    )
    return _BASE_BYTES + max(stages)


def check_scan(scan: HeightField, sigma_s_m: float, parameters: BakeParameters, limit_bytes: int | None) -> None:
    """Refuse a scan of impossible scale, or whose refined heights and spectra alone are too large to be made.

    Raises
    ------
    ScanError, ParameterError, SizeLimitError
        With the numbers.
    """
    check_scale(scan, sigma_s_m)
    if parameters.crop_m is not None:
        return  # what is left of it is checked as a patch
    factor_x, factor_y = refine_factors(scan, parameters.pixel_max_m)
    pixels = scan.shape[0] * factor_y, scan.shape[1] * factor_x
    _check(
        _BASE_BYTES + transform_bytes(scan, pixels, sigma_s_m, parameters.series, parameters.frequency_max), limit_bytes
    )


def check_bake(
    patch: HeightField,
    sigma_s_m: float,
    layout: TableLayout,
    parameters: BakeParameters,
    angles_a_block: int,
    limit_bytes: int | None,
) -> None:
    """Refuse the bake of a prepared patch that would take more memory than there is.

    Parameters
    ----------
    limit_bytes
        Most memory that may be taken; None asks the system what is free.

    Raises
    ------
    SizeLimitError
        With both numbers.
    """
    _check(bake_bytes(patch, sigma_s_m, layout, parameters, angles_a_block), limit_bytes)


def fits_memory(
    patch: HeightField,
    sigma_s_m: float,
    layout: TableLayout,
    parameters: BakeParameters,
    angles_a_block: int,
    limit_bytes: int | None,
) -> bool:
    """Whether `check_bake` would let a bake pass."""
    limit = available_bytes() if limit_bytes is None else limit_bytes
    return limit is None or bake_bytes(patch, sigma_s_m, layout, parameters, angles_a_block) <= limit


def _check(wanted: float, limit_bytes: int | None) -> None:
    limit = available_bytes() if limit_bytes is None else limit_bytes
    if limit is not None and wanted > limit:
        raise SizeLimitError(
            f"The bake would take about {wanted / 1e9:.2f} GB of memory and {limit / 1e9:.2f} GB are free for it; crop"
            " the scan, choose a smaller sigma_s or a lower detail, or close other programs."
        )
