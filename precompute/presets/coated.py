# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures that are known for what they are made of: metals, oxides, oil, cuticle, varnish.

The heights are as simple as those of the other presets; the colour comes from the stack or the lacquer that their looks
(`looks.py`) put into the table.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from . import foils, gratings
from .preset import NM, UM, Parameter, Preset, seed
from .randomness import smooth_field


def _ripple(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    """Lines along y whose phase wanders: where it turns by a whole cycle they split."""
    rng = np.random.default_rng(int(values["seed"]))
    wander = values["disorder_percent"] / 100.0
    phase = smooth_field(rng, x, y, size, 1.6 * UM, 3.2 * UM)
    depth = 1.0 + 0.3 * wander * smooth_field(rng, x, y, size, 0.8 * UM, 1.6 * UM)
    lines = np.sin(2.0 * np.pi * x[None, :] / (values["period_um"] * UM) + 1.2 * wander * phase)
    return values["amplitude_nm"] * NM * depth * lines


def _cuticle(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
    rng = np.random.default_rng(int(values["seed"]))
    length = values["waviness_um"] * UM
    return values["rms_nm"] * NM * smooth_field(rng, x, y, size, length, length)


def _of(presets: tuple[Preset, ...], of: str, **changes: Any) -> Preset:
    """A preset of another module with other words and defaults: ``values`` by the parameters' names."""
    base = next(preset for preset in presets if preset.name == of)
    values = changes.pop("values", {})
    parameters = tuple(replace(p, default=values.get(p.name, p.default)) for p in base.parameters)
    return replace(base, parameters=parameters, **changes)


PRESETS = (
    _of(
        foils.PRESETS, "foil", name="gold_foil", label="Gold Foil",
        description="Two crossed gratings embossed in gold: what gold does not reflect, green to violet, is missing.",
        source="Relief as of the holographic foil (R. van Renesse, Optical Document Security); n and k of gold: "
        "Johnson and Christy, Phys. Rev. B 6 (1972) 4370.",
    ),
    _of(
        gratings.PRESETS, "sinusoid", name="copper_plate", label="Copper Grating",
        description="A grating of 600 lines a millimetre in copper: red orders, weak blue ones.",
        source="Palmer, Diffraction Grating Handbook: holographic gratings, 600 lines/mm = 1.667 um; n and k of "
        "copper: Johnson and Christy, Phys. Rev. B 6 (1972) 4370.",
        values={"period_um": 1.667, "amplitude_nm": 60.0},
    ),
    Preset(
        "titanium_ripple",
        "Laser-Rippled Titanium",
        "Ripple that laser pulses leave on titanium, under an oxide film that makes it blue.",
        "Bonse, Kirner and Krueger, Laser-Induced Periodic Surface Structures, Handbook of Laser Micro- and "
        "Nano-Engineering (2020): ripple of low spatial frequency on metals, somewhat finer than the pulses' "
        "wavelength (800 nm); its depth here is an estimate. Diamanti, Del Curto and Pedeferri, Color Res. Appl. 33 "
        "(2008) 221: anodic films and their colours; the thickness is chosen for blue, the index that of rutile.",
        40.0,
        512,
        _ripple,
        (
            Parameter("period_um", 0.65, "um", 0.1, 10.0, "Distance from crest to crest along x"),
            Parameter("amplitude_nm", 50.0, "nm", 0.0, 1000.0, "Half the height from trough to crest"),
            Parameter("disorder_percent", 100.0, "percent", 0.0, 300.0, "How far the lines wander and split"),
            seed("another place"),
        ),
    ),
    Preset(
        "jewel_beetle",
        "Jewel Beetle",
        "The wing case of a jewel beetle: sixteen layers of melanin and chitin, green in front and blue at the rim.",
        "Stavenga, Wilts, Leertouwer and Hariyama, Phil. Trans. R. Soc. B 366 (2011) 709 (Chrysochroa fulgidissima): "
        "nearly flat, 16 layers where it is green, reflectance peak near 530 nm at normal light. Layers of equal phase "
        "for that peak and the gentle waves of the surface are a model.",
        40.0,
        512,
        _cuticle,
        (
            Parameter("rms_nm", 100.0, "nm", 0.0, 500.0, "Standard deviation of the heights"),
            Parameter("waviness_um", 1.5, "um", 0.2, 20.0, "Correlation length of the heights"),
            seed("another place"),
        ),
    ),
    _of(
        foils.PRESETS, "brushed_metal", name="oily_plate", label="Oil on a Brushed Plate",
        description="A thin film of oil on brushed steel: Newton's colours over a streak of light.",
        source="Relief of EN 10088-2, finishes 2J and 2K, as of the brushed metal; oil of index 1.47, a fringe's "
        "thickness; n and k of iron: Johnson and Christy, Phys. Rev. B 9 (1974) 5056. The film follows the "
        "scratches, which real oil levels out.",
        values={"rms_nm": 60.0},
    ),
    _of(
        foils.PRESETS, "foil", name="lacquered_foil", label="Lacquered Holographic Foil",
        description="Holographic foil of aluminium under a clear varnish, as on trading cards and packaging.",
        source="Relief as of the holographic foil (R. van Renesse, Optical Document Security); varnish: acrylic "
        "(PMMA), Sultanova, Kasarova and Nikolov, Acta Phys. Pol. A 116 (2009) 585.",
    ),
)  # fmt: skip
