# SPDX-License-Identifier: GPL-3.0-or-later
"""From heights to a spectral table: transforms at nodes of kappa, intensities on a polar grid, the sum over the light.

A bake plans the table's coordinates (`plan`), decides what it may cost (`budget`, `cost`), computes one spectrum a node
(`series`, `intensity`, `window`), sums them over the wavelengths (`spectral_sum`) and balances the slices for linear
lookups (`balance`). What comes out is a `precompute.table.SpectralTable`.
"""

from typing import TYPE_CHECKING

from ..faces import on_demand

if TYPE_CHECKING:
    from .baking import BakeReport, bake, bake_file, estimate, resolve_sigma_s
    from .cost import BakeCost, bake_cost
    from .window import default_sigma_s

__all__ = [
    "BakeCost",
    "BakeReport",
    "bake",
    "bake_cost",
    "bake_file",
    "default_sigma_s",
    "estimate",
    "resolve_sigma_s",
]

__getattr__, __dir__ = on_demand(__name__)
