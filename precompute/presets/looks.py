# SPDX-License-Identifier: GPL-3.0-or-later
"""How each preset wants to be looked at: the one table of what a structure brings beside its heights.

A compact disc is more than a heightfield: its tracks run round a hole, and its layer is metal. `LOOKS` says so for
every preset, in the units and words of the panel.

The coherence windows: ordered structures (gratings, discs, foil) get that of sunlight, 16.25 um, a quarter of its
coherence length. It blurs an order by ``lambda / (2 sqrt(2) pi sigma)``, 0.22 degrees of standard deviation at 550 nm,
about what the sun's disc of 0.53 degrees does. A patch allows a quarter of its side, so theirs is 65 um wide instead of
the preset's own size. Random structures keep the ensemble's default, a tenth of the patch, whose mean over windows is
smooth. A table of such a window is large; its values may be off by a tenth where they are a thousandth of the largest.
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
    error_percent
        Largest error of lookups in the table.
    patch_um, patch_pixels
        Side of the patch on which the window fits, and pixels along it; 0 takes the preset's own.
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
    error_percent: float = 2.0
    patch_um: float = 0.0
    patch_pixels: int = 0

    @property
    def is_bright(self) -> bool:
        """Whether it reflects about as much as metal, twenty times as much as skin."""
        return self.fresnel == "CONDUCTOR" or bool(self.substrate)

    def settings(self) -> dict[str, Any]:
        """The same by the names of the panel's properties; the patch is no setting."""
        return {name: value for name, value in asdict(self).items() if not name.startswith("patch_")}

    def summary(self) -> str:
        """In words, for the panel and the docs."""
        surface = "conductor" if self.fresnel == "CONDUCTOR" else f"dielectric of index {self.ior:g}"
        if self.substrate:
            surface = " on ".join((*self.films.split(), self.substrate))
        if self.lacquer:
            surface += f" under {self.lacquer}"
        lies = "radial" if self.orientation == "RADIAL" else "along the UV map"
        window = f"coherence {self.sigma_s_um:g} um" if self.sigma_s_um else "coherence of the patch"
        if self.patch_um:
            window += f" on {self.patch_um:g} um"
        error = "" if self.error_percent == Look.error_percent else f", error {self.error_percent:g} %"
        return f"{surface}, {lies}, levelling {self.level}, {self.ensemble}, {window}{error}"


_SKIN = Look()
_METAL = Look(fresnel="CONDUCTOR")
_GRATING = Look(fresnel="CONDUCTOR", sigma_s_um=16.25, error_percent=10.0, patch_um=65.0)
_DISC = replace(_GRATING, orientation="RADIAL", substrate="Al", lacquer="polycarbonate")

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
    # Whole numbers of tracks; pixels of 40 nm for the Blu-ray disc, twice those of its preset.
    "cd": replace(_DISC, patch_um=65.6),
    "dvd": replace(_DISC, patch_um=65.12),
    "bluray": replace(_DISC, patch_um=65.28, patch_pixels=1632),
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
