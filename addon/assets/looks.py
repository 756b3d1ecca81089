# SPDX-License-Identifier: GPL-3.0-or-later
"""The finished materials of the asset library: one table of what each is made of.

Structure, stuff and coherence come from the presets (`precompute.presets`, with their sources); a look adds what lies
under and around them: pigment, snake scales, paint, prints. What photographs show of each, and which of it the look
keeps to:

* Sunbeam snake: black in the shade, rainbow bands that run along the body in the sun. Corn snake: red saddles, a sheen
  that is hardly seen. Both by `materials.scales`.
* Jewel beetle (Chrysochroa): green in front, blue-green at the rim. Morpho: blue over wide angles, violet at grazing
  ones, brown-black beneath.
* Discs: spokes of colour towards the lamp, white mirror band inside (ECMA-130: data from 25 to 58 mm radius, of 60),
  the print on the other side. A DVD's colours are wider and fewer, a Blu-ray's faint and blue.
* Copper and gold: red and yellow orders, weak blue ones. Titanium: one colour of its oxide film, ripple colours over
  it.
* Brushed steel: a streak across the scratches; in the light of a small lamp single scratches glint in colours of their
  own (Werner, Velinov, Jakob and Hullin, Scratch Iridescence, ACM TOG 36 (2017) 207), since each has its own width.
* Foils, card, sticker: facets and dots of one colour each; varnish mirrors lamps white above them.

Spider silk is not among them: light goes round and through a fibre of a few wavelengths, which is no surface with
heights; the model here has nothing to say about it.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ...precompute.presets import look_of

#: Pigments, linear RGB.
BLACK, GREY, SILVER = (0.012, 0.010, 0.009), (0.03, 0.03, 0.031), (0.18, 0.18, 0.185)


@dataclass(frozen=True)
class Asset:
    """One material of the library; surface and bake are those that suit its preset.

    Parameters
    ----------
    name, catalogue, description
        As the asset browser shows them.
    preset
        Structure, see ``precompute.presets``.
    parameters
        Of the preset, in the units of their names.
    pigment
        Linear RGB under the diffraction.
    surface
        What differs from the preset's look, by the names of the scene's settings.
    species
        Of ``materials.scales.species``, where the material has scales.
    art
        Function of `art` that paints and prints it.
    print_of
        ``DISC`` for a disc's data ring, mirror band and label.
    shape
        What it is pictured on: ``BALL``, ``BODY``, ``DISC``, ``CARD`` or ``PLATE``.
    dim
        How much less light its picture has than others of its kind: what scatters all round is brighter about lamps.
    """

    name: str
    catalogue: str
    description: str
    preset: str
    parameters: dict[str, Any] = field(default_factory=dict)
    pigment: tuple[float, float, float] = BLACK
    surface: dict[str, Any] = field(default_factory=dict)
    species: str = ""
    art: str = ""
    print_of: str = ""
    shape: str = "BALL"
    dim: float = 1.0

    @property
    def is_plain(self) -> bool:
        """Whether it is its preset as that comes, over a pigment."""
        return not (self.parameters or self.surface or self.art)

    @property
    def mirrors(self) -> bool:
        """Whether it reflects as metal or a stack of layers does."""
        return not self.species and (look_of(self.preset).is_bright or "substrate" in self.surface)

    @property
    def bright(self) -> float:
        """How much more it sends back than dark skin, roughly: what its picture is exposed for."""
        if self.species:
            return 5.0 if self.species == "CORN" else 1.4
        return self.dim * (16.0 if self.mirrors else 1.0)

    @property
    def sky(self) -> float:
        """How bright the room is, which a mirror shows in place of its colours."""
        if self.shape == "BALL" and self.mirrors:
            # Layers over melanin send one colour back, metal all of them.
            return (0.5 if "melanin" not in look_of(self.preset).substrate else 1.5) / self.dim
        if self.species == "SUNBEAM":
            return 0.2
        return {"DISC": 0.12, "CARD": 0.35, "PLATE": 0.35}.get(self.shape, 1.0)


_DISC: dict[str, Any] = {"pigment": GREY, "print_of": "DISC", "shape": "DISC"}
_STEEL: dict[str, Any] = {"substrate": "Fe", "films": ""}

ASSETS = (
    Asset("Sunbeam Snake", "Animals", "Xenopeltis: black scales that shine in all colours", "snake", species="SUNBEAM",
          shape="BODY"),
    Asset("Corn Snake", "Animals", "Elaphe: red-brown saddles on orange, a weak sheen", "elaphe", species="CORN",
          shape="BODY"),
    Asset("Jewel Beetle", "Animals", "Layers of melanin and chitin: green, blue at the rim", "jewel_beetle"),
    Asset("Morpho Wing", "Animals", "Ridges of a blue butterfly's scale over a stack of lamellae", "morpho"),
    Asset("CD", "Discs", "Pits 1.6 um apart, mirror band, print on the back; hole on the object's z", "cd", **_DISC),
    Asset("DVD", "Discs", "Pits 0.74 um apart: wide colours", "dvd", **_DISC),
    Asset("Blu-ray", "Discs", "Pits 0.32 um apart: hardly any colour but at grazing light", "bluray", **_DISC),
    Asset("Blazed Grating 400/mm", "Gratings", "Ruled plate that throws its light to one side", "blazed"),
    Asset("Sinusoidal Grating", "Gratings", "Holographic grating of 2 um", "sinusoid"),
    Asset("Copper Grating 600/mm", "Gratings", "Sinusoidal grating in copper: red orders", "copper_plate"),
    Asset("Gold Grating 600/mm", "Gratings", "Sinusoidal grating in gold: yellow and red orders", "copper_plate",
          surface={"substrate": "Au", "films": ""}),
    Asset("Holographic Foil", "Foils", "Crossed gratings of gift wrap", "foil", pigment=GREY),
    Asset("Glitter Foil", "Foils", "Cells of random direction and period", "sinusoid", {"period_um": 1.4}, GREY,
          art="glitter", shape="PLATE"),
    Asset("Gold Foil", "Foils", "Crossed gratings in gold", "gold_foil"),
    Asset("Lacquered Foil", "Foils", "Crossed gratings under a clear varnish", "lacquered_foil", pigment=GREY),
    Asset("Random Bumps", "Foils", "Equal bumps strewn at random after Stam: a halo of pale rings", "stam_bumps",
          {"length_um": 3.0, "width_um": 3.0, "density_per_um2": 0.06}, dim=3.0),
    Asset("Trading Card", "Prints", "A printed picture whose sky is holographic foil under varnish", "lacquered_foil",
          art="card", shape="CARD"),
    Asset("Security Sticker", "Prints", "A guilloche and a seal, each line with its own direction", "lacquered_foil",
          {"period_um": 1.2}, SILVER, art="sticker", shape="PLATE"),
    Asset("Brushed Steel", "Metals", "Hairlines along y: a streak whose lines glint in all colours", "brushed_metal",
          {"scratch_width_um": 2.0, "rms_nm": 70.0, "edges_rms_nm": 50.0}, GREY, _STEEL, art="brush"),
    Asset("Oil on a Brushed Plate", "Metals", "A film of oil on brushed steel", "oily_plate", pigment=GREY),
    Asset("Anodised Titanium", "Metals", "Ripple of laser pulses under an oxide film", "titanium_ripple"),
    Asset("Laser-Marked Plate", "Metals", "Ripple of laser pulses on steel, its direction the polarisation's",
          "titanium_ripple", {"period_um": 0.9}, surface=_STEEL, art="mark", shape="PLATE"),
)  # fmt: skip
