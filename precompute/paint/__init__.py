# SPDX-License-Identifier: GPL-3.0-or-later
"""Grating paint: pictures and recipes as maps of period, depth, direction and presence of one baked structure.

A surface stretched by s along x and y, its coherence window with it, and by q in height has the transform
``s^2 T(s u, s v, q w)``, so that one table serves every period and depth up to its own, pixel by pixel. `make_paint`
turns a recipe (rings, a guilloche, glitter, a photograph in the colours that it is to show ...) into a `Paint`;
`save_paint` stores it as one image beside the table, which drives the material's sockets Scale, Depth, Rotation, Mask.
"""

from typing import TYPE_CHECKING

from ..faces import on_demand

if TYPE_CHECKING:
    from .maps import Paint, load_paint, save_paint
    from .of_table import paint_of_table, table_period
    from .recipes import RECIPES, make_paint

__all__ = ["RECIPES", "Paint", "load_paint", "make_paint", "paint_of_table", "save_paint", "table_period"]

__getattr__, __dir__ = on_demand(__name__)
