# SPDX-License-Identifier: GPL-3.0-or-later
"""Wyko interferometer files (.opd): a directory of named blocks, one of which holds the heights.

Arrays are stored column after column, each from the bottom up, in wavelengths of the instrument's
light (nanometres in the block ``Wavelength``), divided by ``Mult``. ``Pixel_size`` is in
millimetres, ``Aspect`` stretches y.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import number, read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples

_BLOCK = "<16shlH"
_BLOCK_BYTES = 24
_LONGEST_DIRECTORY = 1 << 20
_ARRAY, _SHORT, _FLOAT, _DOUBLE, _LONG = 3, 6, 7, 8, 12
_HEIGHTS = ("RAW_DATA", "RAW DATA", "OPD", "Raw", "SAMPLE_DATA")
_DTYPES = {1: "u1", 2: "<i2", 4: "<f4"}


def read_opd(path: Path) -> list[Channel]:
    """The height arrays of an .opd file."""
    head = read_head(path, _LONGEST_DIRECTORY)
    name, _, length, _ = unpack(_BLOCK, head, 2)
    if text(name) != "Directory" or length % _BLOCK_BYTES or not 0 < length <= len(head) - 2:
        raise ScanError("The .opd file has no valid directory; copy or export it again.")
    arrays, numbers, at = [], {}, 2 + length
    for entry in range(1, length // _BLOCK_BYTES):
        name, kind, size, _ = unpack(_BLOCK, head, 2 + entry * _BLOCK_BYTES)
        if size < 0:
            raise ScanError("The .opd file has no valid directory; copy or export it again.")
        if size:
            if kind == _ARRAY and text(name) in _HEIGHTS:
                arrays.append((text(name), at))
            elif kind in (_SHORT, _FLOAT, _DOUBLE, _LONG):
                numbers[text(name)] = _scalar(path, kind, size, at)
        at += size
    wavelength = number(numbers.get("Wavelength"), "Wavelength") * 1e-9
    factor = wavelength / (number(numbers.get("Mult", 1), "Mult") or 1.0)
    step_x = number(numbers.get("Pixel_size"), "Pixel_size") * 1e-3
    step_y = step_x * number(numbers.get("Aspect", 1.0), "Aspect")
    return [Channel(name, "m", partial(_load, path, at, factor, step_x, step_y)) for name, at in arrays]


def _scalar(path: Path, kind: int, size: int, at: int) -> float | None:
    layout = {_SHORT: "<h" if size == 2 else "<i", _FLOAT: "<f", _DOUBLE: "<d", _LONG: "<i"}[kind]
    with open(path, "rb") as file:
        file.seek(at)
        raw = file.read(min(size, 8))
    try:
        return unpack(layout, raw)[0]
    except ScanError:
        return None


def _load(path: Path, at: int, factor: float, step_x: float, step_y: float) -> Samples:
    with open(path, "rb") as file:
        file.seek(at)
        cols, rows, itemsize = unpack("<HHH", file.read(6))
    if itemsize not in _DTYPES:
        raise ScanError(f"The .opd file holds values of {itemsize} bytes, which are not understood.")
    counts = read_matrix(path, _DTYPES[itemsize], cols, rows, at + 6).T
    decode = partial(_heights, factor=factor)
    return Samples(counts, (cols * step_x, rows * step_y), metadata={"instrument": "Wyko"}, decode=decode)


def _heights(counts: np.ndarray, factor: float) -> np.ndarray:
    values = counts.astype(np.float64)
    if counts.dtype.itemsize > 1:
        values[~(counts < (32766 if counts.dtype.kind == "i" else np.float32(1e38)))] = np.nan
    return values * factor
