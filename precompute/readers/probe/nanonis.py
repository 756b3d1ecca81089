# SPDX-License-Identifier: GPL-3.0-or-later
"""Nanonis images (.sxm): a text header of ``:TAG:`` lines, then big-endian float32 channels in SI units.

``SCAN_DIR`` tells whether the first row is the bottom (``up``) or the top (``down``); backward
channels are stored in the order of the measurement, from right to left. Lines that were never
scanned are NaN.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix
from ..common.channel import Channel, Samples

_LONGEST_HEADER = 4 << 20
_END = b":SCANIT_END:"
_DATA_MARK = b"\x1a\x04"


def read_sxm(path: Path) -> list[Channel]:
    """All channels of a Nanonis image, forward and backward."""
    head = read_head(path, _LONGEST_HEADER)
    end = head.find(_END)
    mark = head.find(_DATA_MARK, end)
    if end < 0 or mark < 0:
        raise ScanError("The .sxm file has no complete header; copy or export it again.")
    tags = _tags(head[:end].decode("latin-1"))
    pixels, size = tags.get("SCAN_PIXELS", "").split(), tags.get("SCAN_RANGE", "").split()
    if len(pixels) < 2 or len(size) < 2:
        raise ScanError("The .sxm header gives no pixels or no size; copy or export it again.")
    cols, rows = (integer(value, "SCAN_PIXELS") for value in pixels[:2])
    size_m = number(size[0], "SCAN_RANGE"), number(size[1], "SCAN_RANGE")
    if "FLOAT" not in tags.get("SCANIT_TYPE", "FLOAT") or "LSBFIRST" in tags.get("SCANIT_TYPE", ""):
        raise ScanError("The .sxm file stores another kind of numbers than big-endian floats; export it as .gsf.")
    downwards = tags.get("SCAN_DIR", "").strip().casefold() == "down"
    metadata = {
        "instrument": "Nanonis",
        "date": f"{tags.get('REC_DATE', '').strip()} {tags.get('REC_TIME', '').strip()}".strip(),
        "fast_axis": "x",
    }
    channels, offset = [], mark + len(_DATA_MARK)
    for name, unit, direction in _data_info(tags.get("DATA_INFO", "")):
        for backward in (False, True) if direction == "both" else (direction == "backward",):
            load = partial(_load, path, offset, rows, cols, size_m, downwards, backward, metadata)
            channels.append(Channel(f"{name} ({'backward' if backward else 'forward'})", unit, load))
            offset += 4 * rows * cols
    return channels


def _tags(header: str) -> dict[str, str]:
    tags: dict[str, str] = {}
    key = ""
    lines: list[str] = []
    for line in header.splitlines():
        line = line.strip("\r")
        if len(line) > 2 and line.startswith(":") and line.rstrip().endswith(":"):
            if key:
                tags[key] = "\n".join(lines)
            key, lines = line.strip().strip(":"), []
        else:
            lines.append(line)
    tags[key] = "\n".join(lines)
    return tags


def _data_info(table: str) -> list[tuple[str, str, str]]:
    """Name, unit and direction (forward, backward, both) of each channel."""
    rows = [line.split() for line in table.splitlines() if line.strip()]
    if not rows or "Name" not in rows[0]:
        raise ScanError("The .sxm header lists no channels; copy or export it again.")
    name, unit, direction = (rows[0].index(column) for column in ("Name", "Unit", "Direction"))
    return [(row[name], row[unit], row[direction].casefold()) for row in rows[1:] if len(row) > direction]


def _load(
    path: Path,
    offset: int,
    rows: int,
    cols: int,
    size_m: tuple[float, float],
    downwards: bool,
    backward: bool,
    metadata: dict,
) -> Samples:
    values = read_matrix(path, ">f4", rows, cols, offset)
    values = values[:: -1 if downwards else 1, :: -1 if backward else 1]
    return Samples(values, size_m, metadata=metadata, decode=np.asarray)
