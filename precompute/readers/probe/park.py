# SPDX-License-Identifier: GPL-3.0-or-later
"""Park Systems TIFF: a picture for the eye, and the heights in private tags.

Tag 50432 marks the format, 50434 holds the counts (bottom row first) and 50435 a binary header.
A value is ``gain * (scale * count + offset)`` in the header's unit.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.binary import ENDS_EARLY, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_shape
from ..common.tiff_page import open_tiff

MARK = 0x0E031301
TAG_MARK, TAG_DATA, TAG_HEADER = 50432, 50434, 50435

# type, name, mode, filter, flatten, track, cols, rows, angle, sine, overscan, forward, up, swap
_HEAD = "<I64s16sdIIIIdIdIII"
# size x, size y, offset x, offset y, rate, set point, its unit, tip bias, sample bias, gain, scale, offset, unit
_SCALES = "<dddddd16sddddd16s"
# min, max, average, compression, logarithmic, square; then, from version 2 on:
_REST = "<iiiIII"
_EXTRA = "<dd16s16s16sI"
_TYPES = {0: "<i2", 1: "<i4", 2: "<f4"}


def read_park(path: Path) -> list[Channel]:
    """The one channel of a Park TIFF."""
    with open_tiff(path) as file:
        tags = file.pages[0].tags
        header, data = _raw(tags, TAG_HEADER), _raw(tags, TAG_DATA)
    head = unpack(_HEAD, header)
    at = _size(_HEAD)
    scales = unpack(_SCALES, header, at)
    at += _size(_SCALES) + _size(_REST)
    kind = unpack(_EXTRA, header, at)[5] if len(header) >= at + _size(_EXTRA) else 0
    if head[0] == 1:
        raise ScanError("The Park file holds a line profile, no map; export the height map.")
    if kind not in _TYPES:
        raise ScanError("The Park file holds an unknown kind of numbers; export it as .gwy or .gsf.")
    name, cols, rows = _wide(head[1]) or "Z Height", head[6], head[7]
    gain, scale, offset, unit = scales[9], scales[10] or 1.0, scales[11], _wide(scales[12]) or "um"
    check_shape(rows, cols)
    metadata = {"instrument": "Park Systems", "mode": _wide(head[2]), "fast_axis": "y" if head[13] else "x"}

    def load() -> Samples:
        dtype = np.dtype(_TYPES[kind])
        if len(data) < rows * cols * dtype.itemsize:
            raise ScanError(ENDS_EARLY)
        counts = np.frombuffer(data, dtype, rows * cols).reshape(rows, cols)
        values = gain * (scale * counts.astype(np.float64) + offset)
        return Samples(values, (scales[0] * 1e-6, scales[1] * 1e-6), metadata=metadata)

    return [Channel(name, unit, load)]


def _size(layout: str) -> int:
    import struct

    return struct.calcsize(layout)


def _raw(tags: Any, code: int) -> bytes:
    tag = tags.get(code)
    if tag is None:
        raise ScanError("The Park file lacks its data or its header; copy or export it again.")
    value = tag.value
    return value if isinstance(value, bytes) else np.asarray(value).astype(np.uint8).tobytes()


def _wide(raw: bytes) -> str:
    """A zero-terminated string of 16-bit characters."""
    return raw.decode("utf-16-le", "replace").split("\0")[0].strip()
