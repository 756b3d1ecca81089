# SPDX-License-Identifier: GPL-3.0-or-later
"""NT-MDT files (.mdt): frames one after the other, of which those of scans (type 0) are read.

A frame has a head of 22 bytes, scales of three axes (offset, step, code of the unit), the settings of the scan, the
shape, and 16-bit counts from the bottom row up. Frames of the multidimensional kind (MDA) are not understood.
"""

from __future__ import annotations

import math
import os
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import read_matrix, unpack
from ..common.channel import Channel, Samples

MAGIC = b"\x01\xb0\x93\xff"
_FIRST_FRAME, _HEAD_BYTES, _LEAST_SETTINGS = 33, 22, 36
_SCANNED, _MDA = 0, (105, 106)
_MOST_FRAMES = 1024
_LENGTHS = {-5: "m", -4: "cm", -3: "mm", -2: "um", -1: "nm", 0: "Ang"}
_OTHER_UNITS = {1: "nA", 2: "V", 4: "kHz", 5: "deg", 6: "%"}
_SIGNALS = (
    "Height", "DFL", "Lateral F", "Bias V", "Current", "FB-Out", "MAG", "MAG*Sin", "MAG*Cos", "RMS", "CalcMag",
    "Phase1", "Phase2", "CalcPhase", "Ex1", "Ex2", "HvX", "HvY", "Snap Back",
)  # fmt: skip


def read_mdt(path: Path) -> list[Channel]:
    """The scans of an .mdt file."""
    end = os.path.getsize(path)
    channels: list[Channel] = []
    kinds = set()
    with open(path, "rb") as file:
        (last,) = unpack("<H", file.read(14), 12)
        at = _FIRST_FRAME
        for _ in range(min(last + 1, _MOST_FRAMES)):
            file.seek(at)
            head = file.read(_HEAD_BYTES)
            size, kind = unpack("<IH", head)
            (settings,) = unpack("<H", head, 20)
            if size < _HEAD_BYTES or at + size > end:
                raise ScanError("The .mdt file ends within a frame; copy or export it again.")
            kinds.add(kind)
            if kind == _SCANNED and settings >= _LEAST_SETTINGS:
                body = file.read(settings + 8)
                channel = _channel(path, body, settings, at + _HEAD_BYTES, {channel.name for channel in channels})
                if channel is not None:
                    channels.append(channel)
            at += size
    if not channels:
        what = "multidimensional frames, which are not understood" if kinds & set(_MDA) else "no scan"
        raise ScanError(f"The .mdt file holds {what}; export the topography as .gsf from Gwyddion.")
    return channels


def _channel(path: Path, body: bytes, settings: int, start: int, taken: set[str]) -> Channel | None:
    x, y, z = (unpack("<ffh", body, at) for at in (0, 10, 20))
    (signal,) = unpack("<B", body, 30)
    _, cols, rows, dots = unpack("<4H", body, settings)
    if cols == 0 or rows == 0:  # points with spectra only
        return None
    start += settings + 8 + (14 + 16 * dots if dots else 0)
    name = _SIGNALS[signal] if signal < len(_SIGNALS) else "Signal"
    if name in taken:
        name = f"{name} ({len(taken) + 1})"
    unit = _LENGTHS.get(z[2], _OTHER_UNITS.get(z[2], "arb"))
    per_x, per_y = (_LENGTH_METRES.get(axis[2]) for axis in (x, y))
    size_m = None
    if per_x is not None and per_y is not None:
        size_m = cols * abs(x[1]) * per_x, rows * abs(y[1]) * per_y
    step = z[1] if math.isfinite(z[1]) and z[1] != 0 else 1.0
    zero = z[0] if math.isfinite(z[0]) else 0.0

    def load() -> Samples:
        counts = read_matrix(path, "<i2", rows, cols, start)
        decode = partial(_heights, step=step, zero=zero)
        return Samples(counts, size_m, metadata={"instrument": "NT-MDT", "fast_axis": "x"}, decode=decode)

    return Channel(name, unit, load)


_LENGTH_METRES = {-5: 1.0, -4: 1e-2, -3: 1e-3, -2: 1e-6, -1: 1e-9, 0: 1e-10}


def _heights(counts: np.ndarray, step: float, zero: float) -> np.ndarray:
    return counts * step + zero
