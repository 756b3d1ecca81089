# SPDX-License-Identifier: GPL-3.0-or-later
"""How each preset wants to be looked at: the one table of what a structure brings beside its heights.

A compact disc is more than a heightfield: its tracks run round a hole, and its layer is metal. `LOOKS` says so for
every preset, in the units and words of the panel.

The coherence windows: ordered structures (gratings, discs, foil) get one of 8 um. It blurs an order by
``lambda / (2 sqrt(2) pi sigma)``, 0.44 degrees of standard deviation at 550 nm, about what the sun's disc of 0.53
degrees does anyway; a wider one would cost memory for sharpness that daylight hides. A patch allows a quarter of its
side. Random structures keep the ensemble's default, a tenth of the patch, whose mean over windows is smooth.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any


@dataclass(frozen=True)
class Look:
    """What suits a preset.

    Parameters
    ----------
    orientation
        Where the scan's x lies on the surface: ``UV``, or ``RADIAL`` for discs.
    fresnel
        ``DIELECTRIC`` or ``CONDUCTOR``.
    ior
        Index of refraction of the dielectric.
    level
        Levelling; computed heights need none.
    ensemble
        How coherence windows are averaged.
    sigma_s_um
        Coherence window in micrometres; 0 takes the ensemble's default.
    substrate, films, lacquer
        What the surface is made of, as the panel has it typed; then the table holds the reflectance. Empty: none.
    """

    orientation: str = "UV"
    fresnel: str = "DIELECTRIC"
    ior: float = 1.55
    level: str = "none"
    ensemble: str = "average"
    sigma_s_um: float = 0.0
    substrate: str = ""
    films: str = ""
    lacquer: str = ""

    @property
    def is_bright(self) -> bool:
        """Whether it reflects about as much as metal, twenty times as much as skin."""
        return self.fresnel == "CONDUCTOR" or bool(self.substrate)

    def settings(self) -> dict[str, Any]:
        """The same by the names of the panel's properties."""
        return asdict(self)

    def summary(self) -> str:
        """In words, for the panel and the docs."""
        surface = "conductor" if self.fresnel == "CONDUCTOR" else f"dielectric of index {self.ior:g}"
        if self.substrate:
            surface = " on ".join((*self.films.split(), self.substrate))
        if self.lacquer:
            surface += f" under {self.lacquer}"
        lies = "radial" if self.orientation == "RADIAL" else "along the UV map"
        window = f"coherence {self.sigma_s_um:g} um" if self.sigma_s_um else "coherence of the patch"
        return f"{surface}, {lies}, levelling {self.level}, {self.ensemble}, {window}"


_SKIN = Look()
_METAL = Look(fresnel="CONDUCTOR")
_GRATING = Look(fresnel="CONDUCTOR", sigma_s_um=8.0)
_DISC = Look(orientation="RADIAL", fresnel="CONDUCTOR", sigma_s_um=8.0, substrate="Al", lacquer="polycarbonate")

#: By the preset's name; a new preset is one more line here.
LOOKS: dict[str, Look] = {
    "snake": _SKIN,
    "elaphe": _SKIN,
    # Kinoshita, Yoshioka and Kawagoe (2002): lamellae of cuticle 0.2 um apart with air between, pigment below. A stack
    # as wide as the scale, under the heights of the ridges, is a model; it peaks at 2 (n d + air) = 468 nm.
    "morpho": Look(substrate="melanin", films="(chitin:60,1:140)x8"),
    "flat": _METAL,
    "sinusoid": _GRATING,
    "blazed": _GRATING,
    "foil": _GRATING,
    "cd": _DISC,
    "dvd": _DISC,
    "bluray": replace(_DISC, sigma_s_um=5.0),
    "brushed_metal": _METAL,
    "stam_bumps": _METAL,
    "gold_foil": replace(_GRATING, substrate="Au"),
    "copper_plate": replace(_GRATING, substrate="Cu"),
    "titanium_ripple": Look(fresnel="CONDUCTOR", substrate="Ti", films="TiO2:50"),
    "jewel_beetle": Look(substrate="melanin", films="(melanin:75,chitin:90)x8"),
    "oily_plate": Look(fresnel="CONDUCTOR", substrate="Fe", films="1.47:400"),
    "lacquered_foil": replace(_GRATING, substrate="Al", lacquer="PMMA"),
}


def look_of(name: str) -> Look:
    """The look of a preset; plain skin where the table has none."""
    return LOOKS.get(name, _SKIN)
