# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers and pictures from a table or a scan: BRDF, maps, reflectance along a plane, orders, colour differences.

The top of the chain. A table answers by lookup (`brdf`, `brdf_map`); a scan answers by the reference sums (`direct_f`,
`direct_xyz`) or by one of the methods of the thesis (`make_method` of ``precompute.evaluate.methods``), which the
grating equation and the tests hold to account.
"""

from typing import TYPE_CHECKING

from ..faces import on_demand

if TYPE_CHECKING:
    from .colour_difference import delta_e_2000
    from .direct import direct_f, direct_xyz
    from .directions import disc_directions, from_angles, to_angles, uvw
    from .disc_map import brdf_map, map_to_srgb, save_map
    from .orders import order_efficiencies
    from .reflectance import Plane, estimated_periods, response
    from .surface import brdf

__all__ = [
    "Plane",
    "brdf",
    "brdf_map",
    "delta_e_2000",
    "direct_f",
    "direct_xyz",
    "disc_directions",
    "estimated_periods",
    "from_angles",
    "map_to_srgb",
    "order_efficiencies",
    "response",
    "save_map",
    "to_angles",
    "uvw",
]

__getattr__, __dir__ = on_demand(__name__)
