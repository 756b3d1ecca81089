# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface data files of ISO 25178-71 (.sdf), ASCII (``aISO-1.0``) and binary (``bISO-1.0``); all lengths in metres.

Profiles are stored one after the other, the first at the top. Missing points are ``BAD`` in ASCII,
NaN or the far end of the integer's range in binary files.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_shape, check_text

_HEAD = "<8s10s12s12sHHddddBBB"
_HEADER_BYTES = 81
_TYPES = {0: "<u1", 1: "<u2", 2: "<u4", 3: "<f4", 4: "<i1", 5: "<i2", 6: "<i4", 7: "<f8"}
_BAD = {1: 2**16 - 1, 2: 2**32 - 1, 5: -(2**15), 6: -(2**31)}


def read_sdf(path: Path) -> list[Channel]:
    """The one surface of an .sdf file."""
    return _binary(path) if read_head(path, 1) == b"b" else _ascii(path)


def _binary(path: Path) -> list[Channel]:
    head = unpack(_HEAD, read_head(path, _HEADER_BYTES))
    cols, rows, dx, dy, dz = head[4], head[5], head[6], head[7], head[8]
    compression, kind = head[10], head[11]
    if compression != 0 or kind not in _TYPES:
        raise ScanError("The .sdf file is compressed or of an unknown kind; save it uncompressed.")

    def load() -> Samples:
        counts = read_matrix(path, _TYPES[kind], rows, cols, _HEADER_BYTES)[::-1]
        missing = counts == _BAD[kind] if kind in _BAD else np.isnan(counts)
        values = counts.astype(np.float64) * dz
        return Samples(values, (cols * dx, rows * dy), missing, metadata={"instrument": text(head[1])})

    return [Channel("Height", "m", load)]


def _ascii(path: Path) -> list[Channel]:
    check_text(path)
    parts = path.read_bytes().decode("latin-1").split("*")
    if len(parts) < 2:
        raise ScanError("The .sdf file has no end of its header; copy or export it again.")
    keys = {}
    for line in parts[0].splitlines()[1:]:
        key, separator, value = line.partition("=")
        if separator:
            keys[key.strip().casefold()] = value.strip()
    cols, rows = integer(keys.get("numpoints"), "NumPoints"), integer(keys.get("numprofiles"), "NumProfiles")
    dx, dy, dz = (number(keys.get(key), key) for key in ("xscale", "yscale", "zscale"))
    check_shape(rows, cols)

    def load() -> Samples:
        flat = np.fromstring(parts[1].replace("BAD", "nan"), sep=" ")
        if flat.size != rows * cols:
            raise ScanError(f"The .sdf file holds {flat.size} values and declares {rows * cols}; export it again.")
        values = flat.reshape(rows, cols)[::-1] * dz
        metadata = {"instrument": keys.get("manufacid", "")}
        return Samples(values, (cols * dx, rows * dy), np.isnan(values), metadata=metadata)

    return [Channel("Height", "m", load)]
