# SPDX-License-Identifier: GPL-3.0-or-later
"""Gwyddion Simple Field (.gsf).

A text header of ``key = value`` lines, one to four zero bytes up to the next multiple of four,
then XRes * YRes little-endian float32, top row first; NaN stands for a missing point
(Gwyddion user guide, "Gwyddion Simple Field Format").
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.binary import read_matrix
from ..common.channel import Channel, Samples
from ..common.limits import check_shape
from ..common.units import ASSUMED_METRES, metres_per

MAGIC = b"Gwyddion Simple Field 1.0\n"
_LONGEST_HEADER = 1 << 20
_OWN_KEYS = ("XRes", "YRes", "XReal", "YReal", "XOffset", "YOffset", "Title", "XYUnits", "ZUnits")


def read_gsf(path: Path) -> list[Channel]:
    """The one channel of a .gsf file."""
    with open(path, "rb") as file:
        head = file.read(_LONGEST_HEADER)
    end = head.find(b"\0")
    if not head.startswith(MAGIC) or end < 0:
        raise ScanError("The .gsf file has no complete header; export the scan again.")
    keys = {}
    for line in head[len(MAGIC) : end].decode("utf-8", "replace").splitlines():
        key, separator, value = line.partition("=")
        if separator:
            keys[key.strip()] = value.strip()
    cols, rows = _integer(keys, "XRes"), _integer(keys, "YRes")
    if cols is None or rows is None:
        raise ScanError("The .gsf header lacks XRes or YRes; export the scan again.")
    check_shape(rows, cols)
    start = end + 4 - end % 4
    expected = start + 4 * rows * cols
    actual = path.stat().st_size
    if actual < expected:
        raise ScanError(f"The .gsf file ends early: {actual} bytes of {expected}; copy or export it again.")

    lateral = metres_per(keys.get("XYUnits") or "m")
    x, y = _number(keys, "XReal"), _number(keys, "YReal")
    size_m = (x * lateral, y * lateral) if lateral is not None and x is not None and y is not None else None
    unit = keys.get("ZUnits") or None
    notes = () if keys.get("XYUnits") or size_m is None else (ASSUMED_METRES,)
    # Only this project writes its list of steps into the header; size and heights were asked about at the import.
    stored = "Processing" in keys

    def load() -> Samples:
        values = read_matrix(path, "<f4", rows, cols, start)[::-1]
        metadata: dict[str, Any] = {key: value for key, value in keys.items() if key not in _OWN_KEYS}
        try:
            metadata["stored_processing"] = json.loads(metadata.pop("Processing", "[]"))
        except (ValueError, RecursionError):
            metadata["stored_processing"] = []
        return Samples(values, size_m, metadata=metadata, decode=np.asarray, notes=notes, trusted=stored)

    return [Channel(keys.get("Title") or "Height", unit, load)]


def _number(keys: dict[str, str], key: str) -> float | None:
    if key not in keys:
        return None
    try:
        return float(keys[key])
    except ValueError:
        raise ScanError(f"The .gsf header says {key} = {keys[key][:40]}, which is no number.") from None


def _integer(keys: dict[str, str], key: str) -> int | None:
    value = _number(keys, key)
    if value is None:
        return None
    if value != value or abs(value) > 2**53 or value != int(value):
        raise ScanError(f"The .gsf header says {key} = {keys[key][:40]}, which is no whole number.")
    return int(value)
