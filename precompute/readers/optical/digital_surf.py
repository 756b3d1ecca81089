# SPDX-License-Identifier: GPL-3.0-or-later
"""Digital Surf files (.sur, .pro) of MountainsMap: a binary header of 512 bytes, then integers, top row first.

A height is ``count * z spacing`` in the z unit; the count ``zmin - 2`` marks a missing point where
the header says that there are such points. ``DSCOMPRESSED`` files hold the integers as zlib streams
behind a directory of their lengths. Further objects (the layers of a series) follow the first, each
with a header of its own.
"""

from __future__ import annotations

import os
import zlib
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import ENDS_EARLY, read_matrix, text, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_loaded, check_shape
from ..common.units import metres_per

# format, objects, version, type, object name, instrument, material, acquisition, range, special, absolute, -, bits,
# zmin, zmax, cols, rows, points, dx, dy, dz, axis names, units of the spacings
_HEAD = "<12s4H30s30s5H8sH4iI3f16s16s16s16s16s16s"
_INVERSION_AT = 290
_PACKED_SIZE_AT = 324
_COMMENT_SIZES_AT = 334
_HEADER_BYTES = 512
_PACKED = b"DSCOMPRESSED"
_MOST_OBJECTS, _MOST_STREAMS = 256, 1 << 16
#: Kinds of objects that are no maps of heights.
_NO_SURFACE = {
    12: "a colour picture", 14: "force curves", 15: "force curves", 17: "a contour", 20: "a spectrum", 21: "spectra",
}  # fmt: skip


@dataclass(frozen=True)
class _Block:
    """Where an object's integers lie, and how."""

    at: int
    rows: int
    cols: int
    dtype: str
    packed: bool


def read_sur(path: Path) -> list[Channel]:
    """The surface of a .sur file, or the layers of a series of them."""
    channels: list[Channel] = []
    at, count = 0, 1
    while len(channels) < count:
        with open(path, "rb") as file:
            file.seek(at)
            head = file.read(_HEADER_BYTES)
        if channels and not head:
            break
        channel, following, declared = _object(path, head, at, len(channels))
        if not channels:
            count = min(max(declared, 1), _MOST_OBJECTS)
        channels.append(channel)
        at = following
    return channels


def _object(path: Path, head: bytes, start: int, index: int) -> tuple[Channel, int, int]:
    """One object, where the next one begins, and how many the file declares."""
    fields = unpack(_HEAD, head.ljust(_HEADER_BYTES, b"\0") if len(head) > 400 else head)
    packed = fields[0] == _PACKED
    if not packed and fields[0] != b"DIGITAL SURF":
        raise ScanError("The .sur file has no valid header where its next layer should begin; save it again.")
    objects, kind, special, bits, zmin = fields[2], fields[4], fields[10], fields[13], fields[14]
    cols, rows, dx, dy, dz = fields[16], fields[17], *fields[19:22]
    name, (unit_x, unit_y, unit_z) = text(fields[24]), (_unit(raw) for raw in fields[25:28])
    if kind in _NO_SURFACE:
        raise ScanError(f"The .sur file holds {_NO_SURFACE[kind]}, no surface; export the surface.")
    if bits not in (16, 32):
        raise ScanError(f"The .sur file holds values of {bits} bits; only 16 and 32 are understood.")
    if rows == 1:
        raise ScanError("The .sur file holds a profile, which is no map; export the surface.")
    per_x, per_y = metres_per(unit_x), metres_per(unit_y)
    if per_x is None or per_y is None:
        raise ScanError(f"The .sur file measures x and y in {unit_x} and {unit_y}, which are no lengths.")
    check_shape(rows, cols)
    (inversion,) = unpack("<H", head, _INVERSION_AT)
    comment, private = unpack("<HH", head, _COMMENT_SIZES_AT)
    block = _Block(start + _HEADER_BYTES + comment + private, rows, cols, f"<i{bits // 8}", packed)
    (packed_size,) = unpack("<I", head, _PACKED_SIZE_AT)
    following = block.at + (packed_size if packed else rows * cols * bits // 8)
    size_m = (cols * dx * per_x, rows * dy * per_y)
    metadata = {"instrument": text(fields[6]) or "Digital Surf", "fast_axis": "x"}
    mark = zmin - 2 if special == 1 else None
    decode = partial(_heights, step=-dz if inversion in (1, 2, 3) else dz, mark=mark)
    axes = {2: (slice(None, None, -1), slice(None, None, -1)), 3: (slice(None), slice(None))}
    turned = axes.get(inversion, (slice(None, None, -1), slice(None)))

    def load() -> Samples:
        counts = _unpacked(path, block) if packed else read_matrix(path, block.dtype, rows, cols, block.at)
        return Samples(counts[turned], size_m, metadata=metadata, decode=decode)

    label = name or "Height"
    return Channel(f"{label} layer {index}" if objects > 1 else label, unit_z, load), following, objects


def _heights(counts: np.ndarray, step: float, mark: int | None) -> np.ndarray:
    values = counts.astype(np.float64) * step
    if mark is not None:
        values[counts == mark] = np.nan
    return values


def _unpacked(path: Path, block: _Block) -> np.ndarray:
    """The integers of zlib streams: their number, raw and packed length of each, then the streams."""
    check_loaded(block.rows, block.cols)
    wanted = block.rows * block.cols * np.dtype(block.dtype).itemsize
    pieces: list[bytes] = []
    there = 0
    with open(path, "rb") as file:
        end = os.path.getsize(path)
        file.seek(block.at)
        (count,) = unpack("<I", file.read(4))
        if count > _MOST_STREAMS:
            raise ScanError(ENDS_EARLY)
        lengths = unpack(f"<{2 * count}I", file.read(8 * count))
        for raw, packed in zip(lengths[::2], lengths[1::2], strict=True):
            if packed > end - file.tell():
                raise ScanError(ENDS_EARLY)
            # Bounded by what the shape allows: a stream may unpack to more than it says.
            piece = zlib.decompressobj().decompress(file.read(packed), max(1, min(raw, wanted - there)))
            pieces.append(piece)
            there += len(piece)
            if there >= wanted:
                break
    if there < wanted:
        raise ScanError(ENDS_EARLY)
    data = b"".join(pieces)
    return np.frombuffer(data, block.dtype, block.rows * block.cols).reshape(block.rows, block.cols)


def _unit(raw: bytes) -> str:
    word = raw.split(b"\0")[0]
    try:
        return word.decode("utf-8").strip()
    except UnicodeDecodeError:
        # A lone byte for micro: of Latin-1, or of the old DOS code page.
        return word.replace(b"\xe6", b"u").decode("latin-1").strip()
