# SPDX-License-Identifier: GPL-3.0-or-later
"""Optical discs: tracks along y, cut into pits of random length.

The reflecting layer's relief is given in real dimensions. A disc is looked at through its plastic, which leaves the
directions of the orders as they are but makes the relief's phase 1.58 times deeper. The discs' looks bake them under a
lacquer of polycarbonate, which does that and all else that a clear layer does; ``depth_nm`` stays the real depth.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from .preset import NM, UM, Parameter, Preset, seed


def _disc(clock_um: float, shortest: int, longest: int) -> Any:
    """A builder of pits and lands whose lengths are ``shortest`` to ``longest`` clock periods."""

    def build(x: np.ndarray, y: np.ndarray, size: tuple[float, float], values: Mapping[str, Any]) -> np.ndarray:
        rng = np.random.default_rng(int(values["seed"]))
        pitch, width = values["track_pitch_um"] * UM, values["pit_width_um"] * UM
        # The middle of a track lies half a pitch from the edge, so that whole pitches tile.
        track = np.floor(x / pitch).astype(np.int64)
        across = np.abs(x - (track + 0.5) * pitch)
        edge = 0.12 * width  # walls of moulded pits lean
        profile = np.clip((width / 2.0 + edge / 2.0 - across) / edge, 0.0, 1.0)
        count = int(np.ceil(size[1] / (clock_um * UM * (shortest + longest) / 2.0))) * 2 + 8
        result = np.empty((y.size, x.size))
        for number in range(int(track.max()) + 1):
            columns = np.flatnonzero(track == number)
            # Shorter runs are more frequent in the discs' run-length codes, roughly by half for each step of two.
            lengths = np.arange(shortest, longest + 1)
            weights = 2.0 ** (-(lengths - shortest) / 2.0)
            runs = rng.choice(lengths, count, p=weights / weights.sum()) * clock_um * UM
            edges = np.cumsum(runs) - rng.uniform(0.0, runs[0] + runs[1])
            pits = _pits(y, edges, edge)
            result[:, columns] = pits[:, None] * profile[columns][None, :]
        return values["depth_nm"] * NM * result

    return build


def _pits(y: np.ndarray, edges: np.ndarray, wall: float) -> np.ndarray:
    """1 in a pit, 0 on a land, with leaning ends; pits and lands alternate from edge to edge."""
    index = np.searchsorted(edges, y)
    inside = index % 2 == 1
    before = np.abs(y - edges[np.clip(index - 1, 0, edges.size - 1)])
    after = np.abs(edges[np.clip(index, 0, edges.size - 1)] - y)
    to_edge = np.minimum(before, after)
    return np.where(inside, np.clip(0.5 + to_edge / wall, 0.0, 1.0), np.clip(0.5 - to_edge / wall, 0.0, 1.0))


def _parameters(pitch: float, width: float, depth: float) -> tuple[Parameter, ...]:
    return (
        Parameter("track_pitch_um", pitch, "um", 0.1, 10.0, "Distance from track to track along x"),
        Parameter("pit_width_um", width, "um", 0.02, 5.0, "Width of a pit"),
        Parameter("depth_nm", depth, "nm", 0.0, 1000.0, "Height of the relief; the look's plastic deepens its phase"),
        seed("other data"),
    )


PRESETS = (
    Preset(
        "cd",
        "Compact Disc",
        "A pressed audio disc: a grating of 625 tracks a millimetre.",
        "ECMA-130: track pitch 1.6 um, runs of 3 to 11 clock periods of 0.278 um at 1.2 m/s; relief about a quarter of "
        "780 nm in polycarbonate, 120 nm.",
        40.0,
        512,
        _disc(0.278, 3, 11),
        _parameters(1.6, 0.6, 120.0),
    ),
    Preset(
        "dvd",
        "DVD",
        "A pressed DVD: 1351 tracks a millimetre, so only one order of colours is left.",
        "ECMA-267: track pitch 0.74 um, shortest run 0.40 um (3 clock periods of 0.133 um); relief about a quarter of "
        "650 nm in polycarbonate, 105 nm.",
        37.0,
        800,
        _disc(0.133, 3, 11),
        _parameters(0.74, 0.32, 105.0),
    ),
    Preset(
        "bluray",
        "Blu-ray Disc",
        "A pressed Blu-ray disc: 3125 tracks a millimetre, finer than visible light's wavelengths, colours only at "
        "grazing angles.",
        "Blu-ray Disc Association, White Paper BD-ROM: track pitch 0.32 um, shortest run 0.149 um (2 clock periods of "
        "0.0745 um); relief about a quarter of 405 nm in the cover layer, 65 nm.",
        20.48,
        1024,
        _disc(0.0745, 2, 8),
        _parameters(0.32, 0.15, 65.0),
    ),
)
