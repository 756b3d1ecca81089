# SPDX-License-Identifier: GPL-3.0-or-later
"""Keysight's files (.mi; Molecular Imaging, Agilent): lines of a key in 14 columns and its value, then the buffers.

``bufferLabel`` begins the keys of a channel, ``data`` ends the header and says whether counts have 16 or 32 bits;
the greatest count stands for the channel's ``bufferRange``. Rows go from the bottom up.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix
from ..common.channel import Channel, Samples

_LONGEST_HEADER = 1 << 20
_KEY = 14
_KINDS = {"BINARY": ("<i2", 32768.0), "": ("<i2", 32768.0), "BINARY_32": ("<i4", 2147483648.0)}
_MOST_BUFFERS = 256


def read_mi(path: Path) -> list[Channel]:
    """All buffers of a .mi image."""
    head = read_head(path, _LONGEST_HEADER)
    keys: dict[str, str] = {}
    buffers: list[dict[str, str]] = []
    at, kind = 0, None
    while kind is None:
        end = head.find(b"\n", at)
        if end < 0 or len(buffers) > _MOST_BUFFERS:
            raise ScanError("The .mi file has no end of its header; copy or export it again.")
        line = head[at:end].decode("latin-1").rstrip("\r")
        at = end + 1
        key, value = line[:_KEY].strip(), line[_KEY:].strip()
        if line.startswith(" "):
            continue
        if key == "data":
            kind = value
        elif key == "bufferLabel":
            buffers.append({key: value})
        else:
            (buffers[-1] if buffers else keys)[key] = value
    if keys.get("fileType") != "Image":
        raise ScanError("The .mi file holds spectra, no image; export the topography.")
    if kind not in _KINDS:
        raise ScanError("The .mi file stores its data as text; save it in binary form.")
    dtype, full = _KINDS[kind]
    cols, rows = integer(keys.get("xPixels"), "xPixels"), integer(keys.get("yPixels"), "yPixels")
    size_m = number(keys.get("xLength"), "xLength"), number(keys.get("yLength"), "yLength")
    metadata = {"instrument": "Keysight", "date": keys.get("dateAcquired", ""), "fast_axis": "x"}
    channels = []
    for index, buffer in enumerate(buffers):
        step = number(buffer.get("bufferRange"), "bufferRange") / full
        start = at + index * rows * cols * np.dtype(dtype).itemsize
        load = partial(_load, path, dtype, rows, cols, start, step, size_m, metadata)
        channels.append(Channel(buffer["bufferLabel"], buffer.get("bufferUnit"), load))
    return channels


def _load(
    path: Path, dtype: str, rows: int, cols: int, start: int, step: float, size_m: tuple[float, float], metadata: dict
) -> Samples:
    counts = read_matrix(path, dtype, rows, cols, start)
    return Samples(counts, size_m, metadata=metadata, decode=partial(np.multiply, step))
