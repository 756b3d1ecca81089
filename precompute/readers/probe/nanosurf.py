# SPDX-License-Identifier: GPL-3.0-or-later
"""Nanosurf files (.nid, .ezd): an INI header, the mark ``#!``, then one block of integers for each channel.

Rows go from the bottom to the top. A count is worth ``Dim2Range / 2^bits``; signed counts sit in
the middle of the range that begins at ``Dim2Min``.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix
from ..common.channel import Channel, Samples
from ..common.units import metres_per

_LONGEST_HEADER = 4 << 20
_MOST_GROUPS = 64


def read_nid(path: Path) -> list[Channel]:
    """All image channels of a .nid file."""
    head = read_head(path, _LONGEST_HEADER)
    end = head.find(b"#!")
    if end < 0:
        raise ScanError("The .nid file has no data mark; copy or export it again.")
    sections = _ini(head[:end].decode("latin-1"))
    data_set = sections.get("DataSet", {})
    info = sections.get("DataSet-Info", {})
    metadata = {
        "instrument": f"Nanosurf {info.get('Head type', '')}".strip(),
        "date": f"{info.get('Date', '')} {info.get('Time', '')}".strip(),
        "fast_axis": "x",
    }
    channels, offset = [], end + 2
    for group in range(min(integer(data_set.get("GroupCount"), "GroupCount"), _MOST_GROUPS)):
        for number_in_group in range(min(integer(data_set.get(f"Gr{group}-Count", 0), "Count"), _MOST_GROUPS)):
            keys = sections.get(data_set.get(f"Gr{group}-Ch{number_in_group}", ""))
            if keys is None:
                continue
            if keys.get("SaveMode") != "Binary":
                raise ScanError("The .nid file stores its data in another way than binary; export it as .gwy or .gsf.")
            channel, size = _channel(path, keys, offset, metadata)
            offset += size
            if channel is not None:
                channels.append(channel)
    return channels


def _ini(header: str) -> dict[str, dict[str, str]]:
    sections: dict[str, dict[str, str]] = {}
    keys: dict[str, str] = {}
    for line in header.splitlines():
        line = line.strip()
        if line.startswith("[") and line.endswith("]"):
            keys = sections.setdefault(line[1:-1], {})
        elif "=" in line:
            key, _, value = line.partition("=")
            keys[key.strip()] = value.strip()
    return sections


def _channel(path: Path, keys: dict[str, str], offset: int, metadata: dict) -> tuple[Channel | None, int]:
    cols, rows = integer(keys.get("Points"), "Points"), integer(keys.get("Lines"), "Lines")
    bits = integer(keys.get("SaveBits"), "SaveBits")
    if bits not in (8, 16, 32) or cols < 1 or rows < 1:
        raise ScanError(f"The .nid file declares {rows} x {cols} values of {bits} bits; copy or export it again.")
    order = "<" if keys.get("SaveOrder", "Intel") == "Intel" else ">"
    signed = keys.get("SaveSign", "Signed") == "Signed"
    dtype = f"{order}{'i' if signed else 'u'}{bits // 8}"
    size = rows * cols * bits // 8
    per_x, per_y = metres_per(keys.get("Dim0Unit")), metres_per(keys.get("Dim1Unit"))
    if per_x is None or per_y is None or "Dim2Range" not in keys:  # a spectroscopy curve, not an image
        return None, size
    span, low = number(keys["Dim2Range"], "Dim2Range"), number(keys.get("Dim2Min", 0), "Dim2Min")
    size_m = number(keys.get("Dim0Range"), "Dim0Range") * per_x, number(keys.get("Dim1Range"), "Dim1Range") * per_y

    def load() -> Samples:
        counts = read_matrix(path, dtype, rows, cols, offset)
        decode = partial(_heights, step=span / 2.0**bits, zero=low + (span / 2.0 if signed else 0.0))
        return Samples(counts, size_m, metadata=dict(metadata), decode=decode)

    return Channel(f"{keys.get('Dim2Name', 'Channel')} ({keys.get('Frame', '?')})", keys.get("Dim2Unit"), load), size


def _heights(counts: np.ndarray, step: float, zero: float) -> np.ndarray:
    return counts * step + zero
