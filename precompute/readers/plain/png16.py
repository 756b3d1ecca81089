# SPDX-License-Identifier: GPL-3.0-or-later
"""PNG pictures of 16 bits in colour or with alpha, which Pillow would cut to 8.

Chunks, deflate and the five filters of the PNG specification (third edition, sections 4.6, 9 and 10). A filter
takes a byte of the pixel on the left, of the one above and of the one between them, so that all pixels of an
anti-diagonal can be restored at once.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.limits import check_loaded, check_shape

MAGIC = b"\x89PNG\r\n\x1a\n"
#: Samples a pixel of the colour types that Pillow cuts.
SAMPLES = {2: 3, 4: 2, 6: 4}
_DAMAGED = "The image ends early or is damaged; save it again as 16-bit grey PNG."


def header(path: Path) -> tuple[int, int, int, int, int] | None:
    """Width, height, bits, colour type and interlacing of a PNG; None where it is none."""
    with open(path, "rb") as file:
        start = file.read(33)
    if not start.startswith(MAGIC) or len(start) < 33 or start[12:16] != b"IHDR":
        return None
    width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", start[16:29])
    return width, height, bits, colour, interlaced


def read_png16(path: Path) -> np.ndarray:
    """``(rows, cols, samples)`` uint16 of a picture of a colour type in ``SAMPLES``, top row first.

    Raises
    ------
    ScanError
        If it is interlaced, damaged or cut short.
    """
    found = header(path)
    if found is None or found[2] != 16 or found[3] not in SAMPLES:
        raise ScanError(_DAMAGED)
    cols, rows, _, colour, interlaced = found
    if interlaced:
        raise ScanError("The image has 16 bits in colour and is interlaced; save it as 16-bit grey PNG.")
    check_shape(rows, cols)
    check_loaded(rows, cols)
    size = 2 * SAMPLES[colour]
    unpacker, wanted = zlib.decompressobj(), rows * (1 + cols * size)
    pieces, there = [], 0
    with open(path, "rb") as file:
        file.seek(len(MAGIC))
        while len(head := file.read(8)) == 8 and there < wanted:
            length, kind = struct.unpack(">I4s", head)
            body = file.read(length)
            if len(body) < length or len(crc := file.read(4)) < 4:
                raise ScanError(_DAMAGED)
            if zlib.crc32(kind + body) != int.from_bytes(crc, "big"):
                raise ScanError(_DAMAGED)
            if kind == b"IDAT":
                pieces.append(unpacker.decompress(body, wanted - there))
                there += len(pieces[-1])
    if there < wanted:
        raise ScanError(_DAMAGED)
    raw = np.frombuffer(b"".join(pieces), np.uint8).reshape(rows, 1 + cols * size)
    del pieces
    filters, lines = raw[:, 0], raw[:, 1:].reshape(rows, cols, size).copy()
    if filters.max() > 4:
        raise ScanError(_DAMAGED)
    _restore(filters, lines)
    return lines.view(">u2").astype(np.uint16)


def _restore(filters: np.ndarray, lines: np.ndarray) -> None:
    """Undo the filters in place, one anti-diagonal of pixels at a time."""
    if not filters.any():
        return
    rows, cols, size = lines.shape
    nothing = np.zeros((1, size), np.int16)
    for diagonal in range(rows + cols - 1):
        row = np.arange(max(0, diagonal - cols + 1), min(rows, diagonal + 1))
        col = diagonal - row
        here = lines[row, col].astype(np.int16)
        left = np.where((col > 0)[:, None], lines[row, col - 1], nothing).astype(np.int16)
        above = np.where((row > 0)[:, None], lines[row - 1, col], nothing).astype(np.int16)
        corner = np.where(((row > 0) & (col > 0))[:, None], lines[row - 1, col - 1], nothing).astype(np.int16)
        kind = filters[row][:, None]
        guess = left + above - corner
        to_left, to_above, to_corner = abs(guess - left), abs(guess - above), abs(guess - corner)
        paeth = np.where(
            (to_left <= to_above) & (to_left <= to_corner), left, np.where(to_above <= to_corner, above, corner)
        )
        added = np.select([kind == 1, kind == 2, kind == 3, kind == 4], [left, above, (left + above) >> 1, paeth], 0)
        lines[row, col] = (here + added) & 255
