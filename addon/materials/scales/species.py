# SPDX-License-Identifier: GPL-3.0-or-later
"""What fits two snakes: values of the node *Snake Scales*, and the structure that lies on their scales.

Sources. Sunbeam snake: adults of about 1 m, large scales in 15 rows, dark purplish brown above, white, grey or light
yellow below (Grzimek's Animal Life Encyclopedia, 2nd ed., vol. 7, Sunbeam snakes). Corn snake: weakly keeled scales in
27 or 29 rows, black-bordered orange, red or brownish blotches on orange-brown, the belly a chequerboard of black and
white (Jefferson Davis Community College, Alabama, wildlife pages: Corn Snake); a specimen of 4 feet was 4 inches round
(American Cyclopaedia, 1873, Corn Snake). Widths follow from girth and rows, with somewhat over a quarter of the girth
belly. Lengths of scales, tilt, turn, relief and the colours in numbers are estimates by eye.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import radians


@dataclass(frozen=True)
class Species:
    """A snake.

    Parameters
    ----------
    label, text
        For menus.
    preset
        The structure on its scales, of ``precompute.presets``.
    ior
        Of the skin.
    values
        Of the node's sockets; those left out keep their defaults.
    """

    label: str
    text: str
    preset: str
    ior: float
    values: dict[str, object] = field(default_factory=dict)


SPECIES = {
    "SUNBEAM": Species(
        "Sunbeam Snake",
        "Xenopeltis unicolor: large smooth scales of dark brown that shine in all colours",
        "snake",
        1.55,
        {
            "Scale Size": 0.0055,
            "Scale Width": 1.25,
            "Girth": 0.085,
            "Relief": 0.45,
            "Keel": 0.0,
            "Tilt": radians(1.5),
            "Turn": radians(4.0),
            "Variation": 0.3,
            "Ground": (0.0048, 0.0030, 0.0027),
            "Side": (0.0080, 0.0055, 0.0047),
            "Gap Colour": (0.0016, 0.0012, 0.0011),
            "Belly Colour": (0.52, 0.47, 0.38),
            "Belly": 0.26,
            "Chequer": 0.0,
            "Saddles": 0.0,
        },
    ),
    "CORN": Species(
        "Corn Snake",
        "Pantherophis (Elaphe) guttatus: red-brown saddles with black borders on orange, a weak sheen",
        "elaphe",
        1.5,
        {
            "Scale Size": 0.0045,
            "Scale Width": 1.0,
            "Girth": 0.10,
            "Relief": 0.9,
            "Keel": 0.030,
            "Tilt": radians(4.0),
            "Turn": radians(8.0),
            "Variation": 0.25,
            "Ground": (0.46, 0.125, 0.022),
            "Side": (0.46, 0.22, 0.08),
            "Gap Colour": (0.16, 0.075, 0.035),
            "Belly Colour": (0.66, 0.58, 0.45),
            "Belly": 0.30,
            "Chequer": 0.45,
            "Saddles": 1.0,
            "Saddle Spacing": 7.5,
            "Saddle Colour": (0.215, 0.030, 0.010),
            "Border Colour": (0.010, 0.006, 0.005),
        },
    ),
}
