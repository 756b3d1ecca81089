# SPDX-License-Identifier: GPL-3.0-or-later
"""WSxM images (.stp, .top, .cur, .tom): a text header up to ``[Header end]``, then the values.

The file begins with the bottom right corner: rows go upwards, each from right to left. Floats are
in the unit of the Z amplitude; integers span that amplitude between the header's Minimum and Maximum.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix
from ..common.channel import Channel, Samples
from ..common.units import metres_per

_LONGEST_HEADER = 1 << 20
_END = b"[Header end]"
_TYPES = {"short": "<i2", "integer": "<i2", "float": "<f4", "double": "<f8"}


def read_wsxm(path: Path) -> list[Channel]:
    """The one channel of a WSxM image."""
    head = read_head(path, _LONGEST_HEADER)
    end = head.find(_END)
    if end < 0 or b"SxM Image file" not in head[:200]:
        raise ScanError("The WSxM file is no image or has no complete header; export the topography as .stp or .gsf.")
    start = head.find(b"\n", end) + 1
    keys = {}
    for line in head[:end].decode("latin-1").splitlines():
        key, separator, value = line.partition(":")
        if separator:
            keys[key.strip().casefold()] = value.strip()
    cols, rows = integer(keys.get("number of columns"), "columns"), integer(keys.get("number of rows"), "rows")
    kind = keys.get("image data type", "short")
    if kind not in _TYPES:
        raise ScanError(f"The WSxM file holds '{kind[:20]}' values, which are not understood; export it as .gsf.")
    amplitude, unit = _quantity(keys.get("z amplitude", ""), "Z Amplitude")
    size_x = _length(keys.get("x amplitude", ""), "X Amplitude")
    size_y = _length(keys["y amplitude"], "Y Amplitude") if "y amplitude" in keys else size_x
    metadata = {"instrument": "WSxM", "date": keys.get("acquisition time", ""), "fast_axis": "x"}
    low, high = keys.get("minimum"), keys.get("maximum")

    def load() -> Samples:
        values = read_matrix(path, _TYPES[kind], rows, cols, start)[:, ::-1]
        factor = 1.0
        if kind in ("short", "integer"):
            span = number(high, "Maximum") - number(low, "Minimum")
            factor = amplitude / span if span > 0 else 1.0
        decode = partial(np.multiply, factor, dtype=np.float64)
        return Samples(values, (size_x, size_y), metadata=metadata, decode=decode)

    return [Channel(keys.get("acquisition channel") or "Topography", unit, load)]


def _quantity(value: str, what: str) -> tuple[float, str]:
    pieces = value.split()
    if len(pieces) < 2:
        raise ScanError(f"The WSxM header gives no value and unit for '{what}'; export the scan again.")
    return number(pieces[0], what), " ".join(pieces[1:])


def _length(value: str, what: str) -> float:
    size, unit = _quantity(value, what)
    factor = metres_per(unit)
    if factor is None:
        raise ScanError(f"The WSxM header gives '{what}' in {unit[:20]}, which is no length.")
    return size * factor
