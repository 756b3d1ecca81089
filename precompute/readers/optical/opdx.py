# SPDX-License-Identifier: GPL-3.0-or-later
"""Bruker's Vision64 files (.opdx; Dektak, Contour): a tree of named items, among them matrices of float32.

``/2D_Data/<channel>`` has the matrix, the distances between the outermost pixel centres (``Dimension1Extent``
along y, ``Dimension2Extent`` along x) and the unit of the heights (``DataScale``). Top row first, NaN is missing.
(As Gwyddion and SurfaceTopography read it.)
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import ENDS_EARLY, contents, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_shape
from ..common.units import metres_per

MAGIC = b"VCA DATA\x01\x00\x00\x55"
_SCALARS = {1: "<?", 4: "<h", 5: "<H", 6: "<i", 7: "<I", 0x0A: "<q", 0x0B: "<Q", 0x0C: "<f", 0x0D: "<d"}
_TYPE_ID, _STRING, _QUANTITY, _TIME, _UNITS = 0x0E, 0x12, 0x13, 0x15, 0x18
_ARRAYS, _STRINGS, _POSITIONS = (0x40,), 0x42, 0x7C
_MATRIX, _PLAIN_MATRIX = 0x00, 0x45
_FOLDERS, _END = (0x46, 0x47, 0x7D), 0x7F
_DEEPEST, _MOST_ITEMS = 32, 100_000


@dataclass(frozen=True)
class _Matrix:
    at: int
    rows: int
    cols: int


class _Tree:
    """Walks through the items; every length is compared with what is there."""

    def __init__(self, data: memoryview) -> None:
        self.data, self.at = data, len(MAGIC)
        self.items: dict[str, object] = {}
        self._count = 0
        while self.at < len(data) and self._item("", 0):
            pass

    def _take(self, layout: str) -> int | float:
        (value,) = unpack(layout, self.data, self.at)
        self.at += np.dtype(layout).itemsize
        return value

    def _bytes(self, count: int) -> bytes:
        if count < 0 or self.at + count > len(self.data):
            raise ScanError(ENDS_EARLY)
        self.at += count
        return bytes(self.data[self.at - count : self.at])

    def _length(self) -> int:
        width = int(self._take("<B"))
        if width not in (1, 2, 4):
            raise ScanError("The .opdx file has a length that is not understood; export it as .x3p or .gsf.")
        return int(self._take({1: "<B", 2: "<H", 4: "<I"}[width]))

    def _name(self) -> str:
        return self._bytes(int(self._take("<I"))).decode("utf-8", "replace")

    def _skip(self, count: int) -> None:
        if count < 0 or self.at + count > len(self.data):
            raise ScanError(ENDS_EARLY)
        self.at += count

    def _item(self, folder: str, depth: int) -> bool:
        """One item; False at the end of a folder."""
        self._count += 1
        if depth > _DEEPEST or self._count > _MOST_ITEMS:
            raise ScanError("The .opdx file is nested too deeply; copy or export it again.")
        path = f"{folder}/{self._name()}"
        kind = int(self._take("<B"))
        if kind == _END:
            return False
        if kind in _FOLDERS:
            end = self._length()
            end += self.at
            while self._item(path, depth + 1):
                pass
            self.at = end if end <= len(self.data) else len(self.data)
        elif kind in _SCALARS:
            self.items[path] = self._take(_SCALARS[kind])
        elif kind == _STRING:
            self.items[path] = self._bytes(self._length()).decode("utf-8", "replace")
        elif kind == _QUANTITY:
            count = self._length()
            end = self.at + count
            value = self._take("<d")
            self._name()
            self.items[path] = (value, self._name())
            self.at = end
        elif kind == _UNITS:
            count = self._length()
            end = self.at + count
            self._name()
            unit = self._name()
            self.items[path] = (self._take("<d"), unit)
            self.at = end
        elif kind == _TIME:
            self._skip(9)
        elif kind in (_TYPE_ID, _STRINGS, _POSITIONS, *_ARRAYS):
            self._name()
            count = self._length()
            if kind == _STRINGS:
                self._strings(path, self.at + count)
            else:
                self._skip(count)
        elif kind in (_MATRIX, _PLAIN_MATRIX):
            self._name()
            if kind == _MATRIX:
                self._take("<I")
                self._name()
            count = self._length()
            rows, cols = int(self._take("<I")), int(self._take("<I"))
            self.items[path] = _Matrix(self.at, rows, cols)
            self._skip(count - 8)
        else:
            raise ScanError(f"The .opdx file holds items of the type {kind}, which is unknown; export it as .gsf.")
        return True

    def _strings(self, path: str, end: int) -> None:
        words = []
        while self.at < min(end, len(self.data)):
            words.append(self._name())
        self.items[path] = words


def read_opdx(path: Path) -> list[Channel]:
    """The height matrices of an .opdx file, the primary one first."""
    data = contents(path)
    items = _Tree(data).items
    primary, heights = items.get("/MetaData/PrimaryData2D"), items.get("/MetaData/2D_Channels/Height")
    names = [name for name in ([primary] + (heights if isinstance(heights, list) else [])) if isinstance(name, str)]
    date = " ".join(str(items.get(f"/MetaData/{key}", "")) for key in ("Date", "Time")).strip()
    instrument = str(items.get("/MetaData/MeasurementSettings/InstrumentName", "Bruker"))
    channels = []
    for name in dict.fromkeys(names):
        folder = f"/2D_Data/{name}"
        matrix = items.get(f"{folder}/Matrix")
        if not isinstance(matrix, _Matrix):
            continue
        check_shape(matrix.rows, matrix.cols)
        scale, unit = _quantity(items, f"{folder}/DataScale")
        size_x = _side(items, f"{folder}/Dimension2Extent", matrix.cols)
        size_y = _side(items, f"{folder}/Dimension1Extent", matrix.rows)
        load = partial(_load, data, matrix, scale, (size_x, size_y), {"instrument": instrument, "date": date})
        channels.append(Channel(str(items.get(f"{folder}/DataKind", name)), unit, load))
    if not channels:
        raise ScanError("The .opdx file holds a profile or no heights; export a surface.")
    return channels


def _quantity(items: dict[str, object], path: str) -> tuple[float, str]:
    value = items.get(path)
    if not isinstance(value, tuple):
        raise ScanError(f"The .opdx file lacks {path.rsplit('/', 1)[1]}; copy or export it again.")
    return value


def _side(items: dict[str, object], path: str, count: int) -> float:
    """The extent goes from the first pixel's centre to the last one's."""
    extent, unit = _quantity(items, path)
    factor = metres_per(unit)
    if factor is None:
        raise ScanError(f"The .opdx file measures its sides in {unit[:20]}, which is no length.")
    return extent * factor * count / (count - 1)


def _load(data: memoryview, matrix: _Matrix, scale: float, size_m: tuple[float, float], metadata: dict) -> Samples:
    if matrix.at + 4 * matrix.rows * matrix.cols > len(data):
        raise ScanError(ENDS_EARLY)
    values = np.frombuffer(data, "<f4", matrix.rows * matrix.cols, matrix.at).reshape(matrix.rows, matrix.cols)[::-1]
    return Samples(values, size_m, metadata=metadata, decode=partial(np.multiply, scale, dtype=np.float64))
