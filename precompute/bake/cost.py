# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake will take, said before it starts: seconds, memory, disk."""

from __future__ import annotations

from dataclasses import dataclass

from ..parameters import BakeParameters
from ..scan.heightfield import HeightField
from ..table.layout import TableLayout
from .baking import ANGLES_A_BLOCK, estimate, resolve_sigma_s
from .budget import bake_bytes
from .series import node_count
from .transforms import LAG_CUT

#: Seconds a padded pixel and node of kappa (transforms), a texel and node (spectral sum), and for
#: everything else. For two cores of 2.5 GHz.
_SECONDS_A_PIXEL, _SECONDS_A_TEXEL, _SECONDS_FIXED = 1.4e-8, 2e-8, 0.5

#: Half floats of three channels, hardly compressible.
_BYTES_A_TEXEL_ON_DISK = 6.0


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
        Largest memory of the process; within about a third. All this is for the layout as planned.
    refined_bytes
        Texels that the table may grow to where its error asks for more slices, radii or angles.
    """

    layout: TableLayout
    nodes: int
    shape: tuple[int, int]
    seconds: float
    memory_bytes: float
    refined_bytes: int = 0

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
        From `precompute.scan.preparation.prepare`.
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
    nodes = node_count(parameters.kappa_max * half_range, parameters.tolerance)

    padded = 1.0
    for side, pixels in zip(patch.size_m, patch.shape[::-1], strict=True):
        padded *= pixels * (1.0 + min(side, LAG_CUT * sigma_s) / side)
    texels = layout.n_r * layout.n_phi * layout.n_w

    seconds = _SECONDS_FIXED + _SECONDS_A_PIXEL * padded * nodes + _SECONDS_A_TEXEL * texels * nodes
    memory = bake_bytes(patch, sigma_s, layout, parameters, ANGLES_A_BLOCK)
    return BakeCost(layout, nodes, patch.shape, seconds, memory, max(parameters.refined_bytes, layout.texel_bytes))
