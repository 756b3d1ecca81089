# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake will take, said before it starts: seconds, memory, disk."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .bake import estimate, resolve_sigma_s
from .constants import W_MAX, WAVELENGTH_MIN_M
from .heightfield import HeightField
from .intensity import BAND_MARGIN, LAG_CUT, LAG_ROOM, RADIAL_STEP, lobe_width
from .layout import TableLayout
from .parameters import BakeParameters
from .series import bessel_order

#: Seconds a padded pixel and node of kappa (transforms), a texel and node (spectral sum), and for
#: everything else, libraries among it. Fitted to bakes of six scans on two cores of 2.5 GHz.
_SECONDS_A_PIXEL, _SECONDS_A_TEXEL, _SECONDS_FIXED = 5e-8, 4e-8, 3.0

#: Libraries, wavelengths and buffers that do not grow with the scan.
_BYTES_FIXED = 230e6

#: Half floats of three channels, hardly compressible.
_BYTES_A_TEXEL_ON_DISK = 6.0

#: Copies of the padded transform (complex64) that live at a time, and bytes a pixel of the patch itself.
_TRANSFORMS, _BYTES_A_PIXEL = 3, 40.0


@dataclass(frozen=True)
class BakeCost:
    """Prediction for one bake.

    Parameters
    ----------
    layout
        The table's.
    nodes
        Terms in kappa.
    shape
        Rows and columns of the prepared patch.
    seconds
        Wall time on an ordinary machine; within a factor of about two.
    memory_bytes
        Largest memory of the process; within about a third.
    """

    layout: TableLayout
    nodes: int
    shape: tuple[int, int]
    seconds: float
    memory_bytes: float

    @property
    def texel_bytes(self) -> int:
        """Texture memory of the table in a renderer."""
        return self.layout.texel_bytes

    @property
    def disk_bytes(self) -> float:
        """Size of the table's files."""
        return self.layout.width * self.layout.height * _BYTES_A_TEXEL_ON_DISK


def bake_cost(patch: HeightField, parameters: BakeParameters) -> BakeCost:
    """Predict what baking a prepared patch takes.

    Parameters
    ----------
    patch
        From `precompute.prepare.prepare`.
    parameters
        Of the bake.

    Raises
    ------
    SizeLimitError
        If the table would be larger than ``parameters.limit_bytes``.
    """
    layout = estimate(patch, parameters)
    sigma_s = resolve_sigma_s(patch, parameters)
    half_range = 0.5 * float(patch.heights.max() - patch.heights.min())
    kappa_max = 2.0 * math.pi * W_MAX / WAVELENGTH_MIN_M
    nodes = max(bessel_order(kappa_max * half_range, parameters.tolerance) + 1, 4)

    lobe = lobe_width(sigma_s)
    band_step = 0.5 / (W_MAX / WAVELENGTH_MIN_M + BAND_MARGIN * lobe)
    padded, fine = 1.0, 1.0
    for side, pixels in zip(patch.size_m, patch.shape[::-1], strict=True):
        lag = min(side, LAG_CUT * sigma_s)
        padded *= pixels * (1.0 + lag / side)
        fine *= 2.0 * LAG_ROOM * lag / band_step + 8.0
    texels = layout.n_r * layout.n_phi * layout.n_w
    radii = W_MAX / WAVELENGTH_MIN_M / (RADIAL_STEP * lobe)

    seconds = _SECONDS_FIXED + _SECONDS_A_PIXEL * padded * nodes + _SECONDS_A_TEXEL * texels * nodes
    memory = (
        _BYTES_FIXED
        + _BYTES_A_PIXEL * patch.shape[0] * patch.shape[1]
        + max(8.0 * _TRANSFORMS * padded, 12.0 * texels + 2.0 * 96.0 * radii * (16.0 * 8.0 + 4.0 * nodes))
        + 4.0 * fine * nodes
    )
    return BakeCost(layout, nodes, patch.shape, seconds, memory)
