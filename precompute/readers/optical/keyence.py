# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyence's laser microscopes (.vk3, .vk4; .vk6 and .vk7, which hold a .vk4 in a zip archive).

A table of offsets leads to the measurement's conditions (picometres a pixel along x and y, and a digit of
height) and to up to three height images of 16 or 32 bits, top row first. The format has no mark of missing
points. (Layout as read by Gwyddion, SurfaceTopography and surfalize.)
"""

from __future__ import annotations

import zipfile
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.archive import member
from ..common.binary import ENDS_EARLY, contents, unpack
from ..common.channel import Channel, Samples
from ..common.limits import LIMIT_FILE_BYTES, check_shape

_OFFSETS_AT, _HEIGHTS_AT = 12, 36
_DATE_AT, _SCALES_AT = 4, 168
_IMAGE_HEAD = "<7I"
_PALETTE_BYTES = 768
_TYPES = {16: "<u2", 32: "<u4"}


def read_vk(path: Path) -> list[Channel]:
    """The height images of a Keyence file."""
    data = contents(path)
    if bytes(data[:3]) in (b"VK6", b"VK7"):
        with zipfile.ZipFile(path) as archive:
            data = memoryview(member(archive, "Vk4File", LIMIT_FILE_BYTES, bytes(data[:3]).decode()))
    if bytes(data[:4]) not in (b"VK3_", b"VK4_"):
        raise ScanError("The Keyence file holds no VK4 data; copy or export it again.")
    (conditions,) = unpack("<I", data, _OFFSETS_AT)
    year, month, day, hour, minute, second = unpack("<6I", data, conditions + _DATE_AT)
    pixel_x, pixel_y, digit = unpack("<3I", data, conditions + _SCALES_AT)
    metadata = {
        "instrument": "Keyence",
        "date": f"{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}",
    }
    channels = []
    for number, at in enumerate(unpack("<3I", data, _HEIGHTS_AT), 1):
        if at == 0:
            continue
        cols, rows, bits = unpack(_IMAGE_HEAD, data, at)[:3]
        if bits not in _TYPES:
            raise ScanError(f"The Keyence file holds heights of {bits} bits; only 16 and 32 are understood.")
        check_shape(rows, cols)
        size_m = cols * pixel_x * 1e-12, rows * pixel_y * 1e-12
        load = partial(_load, data, at + 28 + _PALETTE_BYTES, rows, cols, _TYPES[bits], digit * 1e-12, size_m, metadata)
        channels.append(Channel("Height" if number == 1 else f"Height {number}", "m", load))
    return channels


def _load(
    data: memoryview,
    at: int,
    rows: int,
    cols: int,
    dtype: str,
    step: float,
    size_m: tuple[float, float],
    metadata: dict,
) -> Samples:
    if at + rows * cols * np.dtype(dtype).itemsize > len(data):
        raise ScanError(ENDS_EARLY)
    counts = np.frombuffer(data, dtype, rows * cols, at).reshape(rows, cols)[::-1]
    return Samples(counts, size_m, metadata=metadata, decode=partial(np.multiply, step, dtype=np.float64))
