# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of numpy (.npy, .npz): row 0 is the top, as pictures show it; NaN and masked points are missing.

The header is parsed and compared with the file before anything is allocated; pickled objects are never opened
(numpy.lib.format, versions 1 to 3).
"""

from __future__ import annotations

import io
import zipfile
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.lib import format as npy

from ...errors import ScanError
from ..common.binary import ENDS_EARLY, read_matrix
from ..common.channel import Channel, Samples
from ..common.limits import LIMIT_FILE_BYTES, check_loaded, check_shape

_LONGEST_HEADER = 10000
_MOST_ARRAYS = 256


def read_npy(path: Path) -> list[Channel]:
    """The array of an .npy file; of a stack each plane is a channel."""
    with open(path, "rb") as file:
        shape, fortran, dtype = _header(file)
        start = file.tell()
    planes, rows, cols = _planes(shape)
    check_shape(rows, cols)
    size = rows * cols * dtype.itemsize

    def load(plane: int) -> Samples:
        if fortran and planes == 1:
            return _samples(read_matrix(path, dtype.str, cols, rows, start).T)
        if fortran:
            check_loaded(planes * rows, cols)
            flat = read_matrix(path, dtype.str, planes * rows, cols, start).ravel()
            return _samples(flat.reshape(shape, order="F")[plane])
        return _samples(read_matrix(path, dtype.str, rows, cols, start + plane * size))

    names = ["Array"] if planes == 1 else [f"Plane {plane + 1}" for plane in range(planes)]
    return [Channel(name, None, partial(load, plane)) for plane, name in enumerate(names)]


def read_npz(path: Path) -> list[Channel]:
    """The two-dimensional arrays of an .npz archive."""
    channels, others = [], 0
    with zipfile.ZipFile(path) as archive:
        for info in archive.infolist()[:_MOST_ARRAYS]:
            if not info.filename.endswith(".npy"):
                continue
            with archive.open(info) as file:
                try:
                    shape, _, dtype = _header(io.BytesIO(file.read(_LONGEST_HEADER + 16)))
                except ScanError:
                    others += 1
                    continue
            if len(shape) != 2 or min(shape) < 2 or dtype.kind not in "fiub":
                others += 1
                continue
            channels.append(Channel(info.filename[:-4], None, partial(_load_member, path, info.filename)))
    if not channels:
        raise ScanError("The .npz archive holds no two-dimensional array of numbers; save the heights as one.")
    return channels


def _load_member(path: Path, name: str) -> Samples:
    with zipfile.ZipFile(path) as archive, archive.open(name) as file:
        raw = file.read(LIMIT_FILE_BYTES)
    stream = io.BytesIO(raw)
    shape, fortran, dtype = _header(stream)
    _, rows, cols = _planes(shape)
    check_shape(rows, cols)
    check_loaded(rows, cols)
    start = stream.tell()
    if len(raw) < start + rows * cols * dtype.itemsize:
        raise ScanError(ENDS_EARLY)
    return _samples(np.frombuffer(raw, dtype, rows * cols, start).reshape((rows, cols), order="F" if fortran else "C"))


def _header(file: BinaryIO) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    """Shape, order and type; leaves the stream at the first value."""
    head = io.BytesIO(file.read(_LONGEST_HEADER))  # a header that claims gigabytes finds its end here
    found = None
    try:
        version = npy.read_magic(head)
        read = npy.read_array_header_1_0 if version == (1, 0) else npy.read_array_header_2_0
        found = read(head, max_header_size=_LONGEST_HEADER)
    except (ValueError, TypeError, SyntaxError, OverflowError, RecursionError, MemoryError):
        pass  # the parser of Python's literals names its own limits so
    if found is None:
        raise ScanError("The array has no valid header; save it again with numpy.save.")
    shape, fortran, dtype = found
    if dtype.hasobject:
        raise ScanError("The array holds pickled objects, which are never opened; save the heights as numbers.")
    file.seek(head.tell())
    return shape, fortran, dtype


def _planes(shape: tuple[int, ...]) -> tuple[int, int, int]:
    if len(shape) == 2:
        return 1, *shape  # type: ignore[return-value]
    if len(shape) == 3 and shape[-1] == 1:
        return 1, shape[0], shape[1]
    if len(shape) == 3 and 1 <= shape[0] <= _MOST_ARRAYS:
        return shape
    raise ScanError(f"The array has the shape {shape}; save the heights as rows and columns.")


def _samples(values: np.ndarray) -> Samples:
    if values.dtype.kind not in "fiub":
        raise ScanError(f"The array holds {values.dtype}, no heights; save them as numbers.")
    return Samples(values[::-1], decode=_heights)


def _heights(values: np.ndarray) -> np.ndarray:
    return values.astype(np.float64)
