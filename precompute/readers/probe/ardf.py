# SPDX-License-Identifier: GPL-3.0-or-later
"""Asylum Research's data files (.ardf): sections with a head of 16 bytes, among them images of float32.

A section is a checksum, its size, a name of four letters and flags. The table ``FTOC`` points at ``IMAG`` sections,
each a table, texts (``TTOC``), a definition (``IDEF``: pixels, steps and units) and a box (``IBOX``) of lines, each
behind a head of its own, from the bottom up as in .ibw. The volumes of force curves are left out.
(As Poss's readARDF and magic-afm read it.)
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import ENDS_EARLY, contents, text, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_shape
from ..common.units import metres_per

_HEAD = "<II4sI"
_HEAD_BYTES = 16
_TABLE = "<QII"
_DEFINITION = "<IIQQdd32s32s32s32s"
_MOST_ENTRIES = 4096


def read_ardf(path: Path) -> list[Channel]:
    """The images of an .ardf file."""
    data = contents(path)
    if _name(data, _HEAD_BYTES) != b"FTOC":
        raise ScanError("The .ardf file has no table of contents; copy or export it again.")
    size, count, stride = unpack(_TABLE, data, 2 * _HEAD_BYTES)
    channels = []
    for entry in range(min(count, _MOST_ENTRIES)):
        at = _HEAD_BYTES + 32 + entry * stride
        if stride < 24 or at + 24 > _HEAD_BYTES + size:
            break
        (pointer,) = unpack("<Q", data, at + _HEAD_BYTES)
        if _name(data, at) == b"IMAG" and pointer:
            channels.append(_image(data, pointer))
    if not channels:
        raise ScanError("The .ardf file holds force curves and no image; export the height image as .ibw or .gsf.")
    return channels


def _name(data: memoryview, at: int) -> bytes:
    return unpack(_HEAD, data, at)[2]


def _image(data: memoryview, at: int) -> Channel:
    """Steps over the table and the texts of an image to its definition."""
    for wanted in (b"IMAG", b"TTOC"):
        if _name(data, at) != wanted:
            raise ScanError("The .ardf file has an image of an unknown kind; export it as .ibw or .gsf.")
        (size,) = unpack("<Q", data, at + _HEAD_BYTES)
        at += size
    if _name(data, at) != b"IDEF":
        raise ScanError("The .ardf file has an image without a definition; export it as .ibw or .gsf.")
    (size,) = unpack("<I", data, at + 4)
    cols, rows, _, _, step_x, step_y, unit_x, unit_y, name, unit = unpack(_DEFINITION, data, at + _HEAD_BYTES)
    check_shape(rows, cols)
    at += size
    if _name(data, at) != b"IBOX":
        raise ScanError("The .ardf file has an image without its data; copy or export it again.")
    (head,) = unpack("<I", data, at + 4)
    _, lines, stride = unpack(_TABLE, data, at + _HEAD_BYTES)
    if stride != 4 * cols + _HEAD_BYTES or lines != rows:
        raise ScanError("The .ardf file's image has lines of another length than it declares; export it as .ibw.")
    per_x, per_y = metres_per(text(unit_x)), metres_per(text(unit_y))
    size_m = None if per_x is None or per_y is None else (cols * step_x * per_x, rows * step_y * per_y)
    return Channel(text(name), text(unit) or None, partial(_load, data, at + head, rows, cols, size_m))


def _load(data: memoryview, at: int, rows: int, cols: int, size_m: tuple[float, float] | None) -> Samples:
    line = 4 * cols + _HEAD_BYTES
    if at + rows * line > len(data):
        raise ScanError(ENDS_EARLY)
    lines = np.frombuffer(data, np.uint8, rows * line, at).reshape(rows, line)
    values = lines[:, _HEAD_BYTES:].view("<f4")
    return Samples(values, size_m, metadata={"instrument": "Asylum Research", "fast_axis": "x"}, decode=np.asarray)
