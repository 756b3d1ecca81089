# SPDX-License-Identifier: GPL-3.0-or-later
"""RHK files (.sm4): a tree of objects (identity, offset, size) that leads to pages, of which the images are read.

A page's header gives pixels, metres a pixel (a negative one along x runs leftwards, a positive one along y upwards)
and ``value = count * scale + offset`` in the unit among its strings; counts have 32 bits. (As Gwyddion and spym
read it.)
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import contents, read_matrix, unpack
from ..common.channel import Channel, Samples

_INDEX_HEADER, _INDEX_ARRAY, _PAGE_HEADER, _PAGE_DATA, _STRINGS = 1, 2, 3, 4, 10
_IMAGE = 0
#: Where the objects of a page's header begin: after its numbers and 64 bytes of flags.
_HEADER_BYTES = 4 + 4 * 28 + 64
_LABEL, _X_UNIT, _Y_UNIT, _Z_UNIT = 0, 7, 8, 9
_MOST_PAGES, _MOST_OBJECTS, _MOST_STRINGS = 1024, 64, 64


def read_sm4(path: Path) -> list[Channel]:
    """The images of an .sm4 file."""
    data = contents(path)
    (length,) = unpack("<H", data, 0)
    (count,) = unpack("<I", data, 42)
    index = _objects(data, length + 2, count).get(_INDEX_HEADER)
    if index is None:
        raise ScanError("The .sm4 file has no index of pages; copy or export it again.")
    pages, count = unpack("<II", data, index)
    at = _objects(data, index + 16, count).get(_INDEX_ARRAY, -1)
    channels: list[Channel] = []
    for _ in range(min(pages, _MOST_PAGES)):
        kind, _, count, _ = unpack("<4I", data, at + 16)
        objects = _objects(data, at + 32, count)
        if kind == _IMAGE and _PAGE_HEADER in objects and _PAGE_DATA in objects:
            channels.append(_page(path, data, objects[_PAGE_HEADER], objects[_PAGE_DATA]))
        at += 32 + 12 * count
    if not channels:
        raise ScanError("The .sm4 file holds spectra and no image; export the topography as .gsf.")
    return channels


def _objects(data: memoryview, at: int, count: int) -> dict[int, int]:
    """Where each kind of object lies."""
    if count > _MOST_OBJECTS:
        raise ScanError("The .sm4 file lists more objects than there can be; copy or export it again.")
    found = (unpack("<3I", data, at + 12 * number) for number in range(count))
    return {kind: offset for kind, offset, size in found if offset and size}


def _page(path: Path, data: memoryview, at: int, start: int) -> Channel:
    (strings,) = unpack("<H", data, at + 2)
    cols, rows, _, backward = unpack("<4I", data, at + 4 + 4 * 5)
    step_x, step_y, step_z = unpack("<3f", data, at + 4 + 4 * 13)
    (zero,) = unpack("<f", data, at + 4 + 4 * 19)
    (count,) = unpack("<I", data, at + 4 + 4 * 27)
    place = _objects(data, at + _HEADER_BYTES, count).get(_STRINGS)
    words = [""] * 10 if place is None else _words(data, place, strings)
    if words[_X_UNIT] not in ("m", "") or words[_Y_UNIT] not in ("m", ""):
        raise ScanError("The .sm4 file measures its sides in another unit than metres; export it as .gsf.")
    size_m = (cols * abs(step_x), rows * abs(step_y)) if words[_X_UNIT] else None
    turned = slice(None, None, 1 if step_y > 0 else -1), slice(None, None, -1 if step_x < 0 else 1)

    def load() -> Samples:
        counts = read_matrix(path, "<i4", rows, cols, start)[turned]
        decode = partial(_heights, step=step_z, zero=zero)
        return Samples(counts, size_m, metadata={"instrument": "RHK", "fast_axis": "x"}, decode=decode)

    name = f"{words[_LABEL] or 'Image'} ({'backward' if backward == 1 else 'forward'})"
    return Channel(name, words[_Z_UNIT] or None, load)


def _words(data: memoryview, at: int, count: int) -> list[str]:
    words = []
    for _ in range(min(count, _MOST_STRINGS)):
        (length,) = unpack("<H", data, at)
        (raw,) = unpack(f"<{2 * length}s", data, at + 2)
        words.append(raw.decode("utf-16-le", "replace").rstrip("\0"))
        at += 2 + 2 * length
    return words + [""] * (10 - len(words))


def _heights(counts: np.ndarray, step: float, zero: float) -> np.ndarray:
    return counts * np.float64(step) + zero
