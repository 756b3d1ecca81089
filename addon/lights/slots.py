# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and layout of the scene's custom properties that hold its lights; the page docs/lighting.md lists them.

A material reads them by Attribute nodes of the type View Layer, so whatever scene is rendered, its own lights count.
Each of the `SLOTS` lamps is three arrays of four numbers, which come out as colour (a vector) and alpha:

=============================  ======================================  ==========================================
property                       first three                             fourth
=============================  ======================================  ==========================================
``diffraction_lamp_01``        sun: direction to it; others: position  kind, see `KINDS`; 0 is dark
``diffraction_lamp_01_u``      area: half its extent along its x       sun: its angle; ball: radius; area: spread
``diffraction_lamp_01_v``      area: half its extent along its y       1 where light within is uneven, else 0
=============================  ======================================  ==========================================

All in world space, metres and radians. ``diffraction_lamps`` is the number of slots in use (those after it are dark),
``diffraction_to_red``, ``_green`` and ``_blue`` are the rows of the matrix from XYZ to the file's working space.
"""

from __future__ import annotations

#: How properties begin that drivers of the list refer to: matrices of empties, copies of animated settings.
FRAME = "diffraction_frame_"

#: Lamps that a scene's list holds. Each lamp is a closure of 64 bytes in OSL, of which OptiX keeps 1,024 bytes in all
#: (`materials.closures`), so that more than 14 would not fit there whatever the material.
SLOTS = 16

#: Kinds of lamps. A ball stands for point and spot lamps and whatever else has a radius.
KINDS = {"NONE": 0, "SUN": 1, "BALL": 2, "RECTANGLE": 3, "ELLIPSE": 4}

COUNT = "diffraction_lamps"

#: Rows of the matrix from XYZ (white D65) to the working space.
MATRIX = ("diffraction_to_red", "diffraction_to_green", "diffraction_to_blue")

#: Endings of a lamp's three properties.
PARTS = ("", "_u", "_v")


def names(slot: int) -> tuple[str, str, str]:
    """The three properties of a lamp, counted from 1."""
    place, u, v = (f"diffraction_lamp_{slot:02d}{part}" for part in PARTS)
    return place, u, v
