# SPDX-License-Identifier: GPL-3.0-or-later
"""NanoFocus files (.nms): a header of 3468 bytes, then 16-bit counts, top row first.

Counts 0 to 65534 span the heights from zmin to zmax in micrometres, 65535 marks a missing point; the pixel's
sides are in millimetres. (As SurfaceTopography and surfalize read it.)
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import read_head, read_matrix, unpack
from ..common.channel import Channel, Samples

_HEADER_BYTES, _RANGE_AT, _GRID_AT = 3468, 16, 1368
_MISSING = 65535


def read_nms(path: Path) -> list[Channel]:
    """The one surface of an .nms file."""
    head = read_head(path, _HEADER_BYTES)
    low, high = unpack("<dd", head, _RANGE_AT)
    cols, rows, step_x, step_y = unpack("<IIdd", head, _GRID_AT)
    if not (np.isfinite([low, high]).all() and high > low):
        raise ScanError("The .nms file gives no range of heights; copy or export it again.")
    decode = partial(_heights, low=low, step=(high - low) / (_MISSING - 1))

    def load() -> Samples:
        counts = read_matrix(path, "<u2", rows, cols, _HEADER_BYTES)[::-1]
        size_m = cols * step_x * 1e-3, rows * step_y * 1e-3
        return Samples(counts, size_m, metadata={"instrument": "NanoFocus"}, decode=decode)

    return [Channel("Height", "um", load)]


def _heights(counts: np.ndarray, low: float, step: float) -> np.ndarray:
    return np.where(counts == _MISSING, np.nan, low + counts * step)
