# SPDX-License-Identifier: GPL-3.0-or-later
"""Heights before their diffraction: the heightfield, and all that may be done to it.

A reader or a preset makes a `HeightField`; `prepare` levels, clips, crops, fills, smooths and refines it as the
parameters say; each step is a function of its own and leaves a line in the field's list of steps. `scan_info` and
`find_lattice` look at it, `write_gsf` stores it.
"""

from typing import TYPE_CHECKING

from ..faces import on_demand

if TYPE_CHECKING:
    from .clipping import clip, crop
    from .gsf import write_gsf
    from .heightfield import HeightField
    from .info import scan_info
    from .lattice import find_lattice, power_spectrum
    from .levelling import level
    from .missing import fill_missing
    from .orientation import flip_x, flip_y, rotate90
    from .preparation import prepare
    from .resample import refine
    from .row_alignment import align_rows
    from .smoothing import smooth
    from .tiling import make_tileable

__all__ = [
    "HeightField",
    "align_rows",
    "clip",
    "crop",
    "fill_missing",
    "find_lattice",
    "flip_x",
    "flip_y",
    "level",
    "make_tileable",
    "power_spectrum",
    "prepare",
    "refine",
    "rotate90",
    "scan_info",
    "smooth",
    "write_gsf",
]

__getattr__, __dir__ = on_demand(__name__)
