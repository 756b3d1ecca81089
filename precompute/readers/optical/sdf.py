# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface data files of ISO 25178-71 (.sdf), versions 1.0 and 2.0, and of its forerunner BCR-1.0, in metres.

ASCII (``aISO-1.0``) or binary (``bISO-1.0``, little-endian; version 2.0 counts points in 32 bits in place of 16).
Profiles are stored one after the other, the first at the top. The mark of a point that was not measured is ``BAD`` in
ASCII, else the least value of the number type in ISO files and the greatest in BCR files, which still had unsigned
types; of floats anything beyond the nominal end of their range (3.4e38, 1.7e308) and NaN are taken as marks as well.
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_loaded, check_shape, check_text

_START, _COUNTS, _REST = "<8s10s12s12s", {b"ISO-2.0": "<II"}, "<ddddBBB"
_TYPES = {0: "<u1", 1: "<u2", 2: "<u4", 3: "<f4", 4: "<i1", 5: "<i2", 6: "<i4", 7: "<f8"}
_ENDS = {4: 3.4e38, 8: 1.7e308}
#: How BCR files may spell their types.
_NAMES = {
    "UINT8": 0,
    "UINT16": 1,
    "UINT32": 2,
    "FLOAT": 3,
    "INT8": 4,
    "INT16": 5,
    "INTEGER": 5,
    "INT32": 6,
    "DOUBLE": 7,
}


def read_sdf(path: Path) -> list[Channel]:
    """The one surface of an .sdf file."""
    return _binary(path) if read_head(path, 1) in (b"b", b"B") else _ascii(path)


def _missing(values: np.ndarray, dtype: np.dtype, bcr: bool) -> np.ndarray:
    """Which values, read as ``dtype`` or from text that declares it, mark a point without a height."""
    if dtype.kind == "f":
        return ~(np.abs(values) < _ENDS[dtype.itemsize])
    limits = np.iinfo(dtype)
    return np.isnan(values) | (values == (limits.max if bcr or dtype.kind == "u" else limits.min))


def _heights(values: np.ndarray, dtype: np.dtype, bcr: bool, dz: float) -> np.ndarray:
    heights = values.astype(np.float64)
    heights[_missing(values, dtype, bcr)] = np.nan
    return heights * dz


def _binary(path: Path) -> list[Channel]:
    head = read_head(path, 128)
    magic, maker, _, _ = unpack(_START, head)
    at = 42
    counts = _COUNTS.get(magic[1:], "<HH")
    cols, rows = unpack(counts, head, at)
    at += 8 if counts == "<II" else 4
    dx, dy, dz, _, compression, kind, _ = unpack(_REST, head, at)
    at += 35
    if compression != 0 or kind not in _TYPES:
        raise ScanError("The .sdf file is compressed or of an unknown kind; save it uncompressed.")
    dtype, size_m = np.dtype(_TYPES[kind]), (cols * dx, rows * dy)
    decode = partial(_heights, dtype=dtype, bcr=magic[1:4] == b"BCR", dz=dz)

    def load() -> Samples:
        counts = read_matrix(path, _TYPES[kind], rows, cols, at)[::-1]
        return Samples(counts, size_m, metadata={"instrument": text(maker)}, decode=decode)

    return [Channel("Height", "m", load)]


def _ascii(path: Path) -> list[Channel]:
    check_text(path)
    content = path.read_bytes().decode("latin-1")
    bcr = content[1:4] == "BCR"
    if bcr:
        content = re.sub(r";[^\n]*", "", content)  # comments, which ISO does not have
    parts = re.split(r"^[ \t]*\*[ \t]*\r?$", content, maxsplit=2, flags=re.MULTILINE)
    if len(parts) < 2:
        raise ScanError("The .sdf file has no end of its header; copy or export it again.")
    keys = {}
    for line in parts[0].splitlines()[1:]:
        key, separator, value = line.partition("=")
        if separator:
            keys[key.strip().casefold()] = value.strip()
    cols, rows = integer(keys.get("numpoints"), "NumPoints"), integer(keys.get("numprofiles"), "NumProfiles")
    dx, dy, dz = (number(keys.get(key), key) for key in ("xscale", "yscale", "zscale"))
    kind = _NAMES.get(keys.get("datatype", "7").upper())
    if kind is None:
        kind = integer(keys.get("datatype", "7"), "DataType")
    if kind not in _TYPES:
        raise ScanError("The .sdf file is of an unknown kind; save it in binary form.")
    check_shape(rows, cols)
    check_loaded(rows, cols)

    def load() -> Samples:
        try:
            flat = np.array([np.nan if word == "BAD" else float(word) for word in parts[1].split()])
        except ValueError:
            raise ScanError("The .sdf file holds a word where a number should be; export it again.") from None
        if flat.size != rows * cols:
            raise ScanError(f"The .sdf file holds {flat.size} values and declares {rows * cols}; export it again.")
        decode = partial(_heights, dtype=np.dtype(_TYPES[kind]), bcr=bcr, dz=dz)
        metadata = {"instrument": keys.get("manufacid", "")}
        return Samples(flat.reshape(rows, cols)[::-1], (cols * dx, rows * dy), metadata=metadata, decode=decode)

    return [Channel("Height", "m", load)]
