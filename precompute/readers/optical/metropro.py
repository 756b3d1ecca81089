# SPDX-License-Identifier: GPL-3.0-or-later
"""Zygo's MetroPro files (.dat): a big-endian header, pictures of the fringes, then the phase as 32-bit counts.

A count is ``scale * wavelength * obliquity / R`` metres, R from the phase resolution, negative where the header
says that the data are inverted; counts from 2147483640 on are missing points. Top row first. (MetroPro
Reference Guide, "Data file format"; inverted as Gwyddion reads it.)
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples

MAGIC = (b"\x88\x1b\x03\x6f", b"\x88\x1b\x03\x70", b"\x88\x1b\x03\x71")
_HEADER_BYTES = 834
_MISSING = 2147483640
_RESOLUTIONS = {0: 4096, 1: 32768, 2: 131072}


def read_dat(path: Path) -> list[Channel]:
    """The one surface of a MetroPro file."""
    head = read_head(path, _HEADER_BYTES)
    (start,) = unpack(">I", head, 6)
    (fringe_bytes,) = unpack(">I", head, 60)
    cols, rows = unpack(">HH", head, 68)
    scale, wavelength, _, obliquity, _, pixel = unpack(">6f", head, 164)
    (resolution,) = unpack(">h", head, 218)
    (inverted,) = unpack(">h", head, 232)
    if start < _HEADER_BYTES:
        raise ScanError("The MetroPro file has no complete header; copy or export it again.")
    if cols == 0 or rows == 0:
        raise ScanError("The MetroPro file holds no heights, only pictures of fringes; save it with its phase.")
    if resolution not in _RESOLUTIONS:
        raise ScanError(f"The MetroPro file has the phase resolution {resolution}, which is not understood.")
    step = scale * wavelength * obliquity / _RESOLUTIONS[resolution] * (-1.0 if inverted else 1.0)
    size_m = (cols * pixel, rows * pixel) if pixel > 0 else None
    metadata = {"instrument": f"Zygo {text(head[242:254])}".strip(), "date": text(head[12:42])}

    def load() -> Samples:
        counts = read_matrix(path, ">i4", rows, cols, start + fringe_bytes)[::-1]
        return Samples(counts, size_m, metadata=metadata, decode=partial(_heights, step=step))

    return [Channel("Height", "m", load)]


def _heights(counts: np.ndarray, step: float) -> np.ndarray:
    return np.where(counts >= _MISSING, np.nan, counts * np.float64(step))
