# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces that binary formats share: arrays and structures read with a look at what is really there."""

from __future__ import annotations

import mmap
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from .limits import check_shape, cropping

ENDS_EARLY = "The file ends early; copy or export it again."


def read_matrix(path: Path, dtype: str, rows: int, cols: int, offset: int) -> np.ndarray:
    """``(rows, cols)`` numbers from a file, in the file's order; mapped, not loaded, where a part is wanted.

    Raises
    ------
    ScanError
        If the shape makes no sense or the file is too short for it.
    """
    check_shape(rows, cols)
    kind = np.dtype(dtype)
    if offset < 0 or offset + rows * cols * kind.itemsize > os.path.getsize(path):
        raise ScanError(ENDS_EARLY)
    if cropping():
        return np.memmap(path, kind, "r", offset, (rows, cols))
    return np.fromfile(path, kind, rows * cols, offset=offset).reshape(rows, cols)


def contents(path: Path) -> memoryview:
    """All bytes of a file; mapped where only a part of a scan is wanted."""
    if not cropping():
        return memoryview(path.read_bytes())
    with open(path, "rb") as file:
        return memoryview(mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ))


def read_head(path: Path, count: int) -> bytes:
    """The first ``count`` bytes, or fewer where the file is shorter."""
    with open(path, "rb") as file:
        return file.read(count)


def unpack(layout: str, data: bytes | memoryview, offset: int = 0) -> tuple[Any, ...]:
    """``struct.unpack_from`` that says in one sentence when the bytes are not there."""
    if offset < 0 or offset + struct.calcsize(layout) > len(data):
        raise ScanError(ENDS_EARLY)
    return struct.unpack_from(layout, data, offset)


def text(raw: bytes) -> str:
    """A zero-terminated string of UTF-8 or Latin-1."""
    raw = raw.split(b"\0")[0]
    try:
        return raw.decode("utf-8").strip()
    except UnicodeDecodeError:
        return raw.decode("latin-1").strip()


def number(value: Any, what: str) -> float:
    """A finite number from a header's string.

    Raises
    ------
    ScanError
        Naming ``what`` if it is missing or no number.
    """
    try:
        result = float(value)
    except (TypeError, ValueError):
        result = float("nan")
    if not np.isfinite(result):
        raise ScanError(f"The header gives no number for '{what}'; export the scan again.")
    return result


def integer(value: Any, what: str) -> int:
    """A whole number from a header's string, as :func:`number`."""
    return int(number(value, what))
