# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensofar files (.plu, .apx): a fixed header of 500 bytes, then layers of float32 micrometres, top row first.

The value 1000001 marks a missing point.
"""

from __future__ import annotations

import os
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples

_CALIBRATION_AT, _KIND_AT, _LAYERS_AT = 388, 428, 488
_DATA_AT = 500
_TOPOGRAPHY = 3
_MISSING = 1000001.0


def read_plu(path: Path) -> list[Channel]:
    """All layers of a .plu file."""
    head = read_head(path, _DATA_AT)
    _, _, _, _, step_x, step_y = unpack("<IIIfff", head, _CALIBRATION_AT)
    (kind,) = unpack("<I", head, _KIND_AT)
    if kind != _TOPOGRAPHY:
        raise ScanError("The .plu file holds no topography (a profile or another kind of measurement).")
    _, layers, _, _, images = unpack("<5B", head, _LAYERS_AT)
    metadata = {"instrument": "Sensofar", "date": text(head[:128])}
    channels, at, end = [], _DATA_AT, os.path.getsize(path)
    for layer in range(layers):
        with open(path, "rb") as file:
            file.seek(at)
            rows, cols = unpack("<II", file.read(8))
        if at + 8 + 4 * rows * cols > end:
            raise ScanError("The .plu file ends early; copy or export it again.")
        name = "Height" if layers == 1 else f"Height layer {layer}"
        load = partial(_load, path, at + 8, rows, cols, step_x, step_y, metadata)
        channels.append(Channel(name, "um", load))
        at += 8 + 4 * rows * cols + 8 + 3 * rows * cols * images
    return channels


def _load(path: Path, at: int, rows: int, cols: int, step_x: float, step_y: float, metadata: dict) -> Samples:
    values = read_matrix(path, "<f4", rows, cols, at)[::-1]
    return Samples(values, (cols * step_x * 1e-6, rows * step_y * 1e-6), metadata=metadata, decode=_heights)


def _heights(values: np.ndarray) -> np.ndarray:
    return np.where(values == _MISSING, np.nan, values.astype(np.float64))
