# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures on disk: 8-bit PNG for eyes, 32-bit EXR for numbers. Row 0 of every array is the bottom."""

from __future__ import annotations

import os
import struct
import zlib
from pathlib import Path

import numpy as np

from ..errors import OutputError
from .atomic import atomic_path
from .exr import write_image

SUFFIXES = (".png", ".exr")


def check_image_path(path: str | os.PathLike[str]) -> Path:
    """The path as it is, or OutputError if its suffix is neither ``.png`` nor ``.exr``."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise OutputError(f"Cannot write '{path.name}': give it the suffix {' or '.join(SUFFIXES)}.")
    return path


def write_png(path: str | os.PathLike[str], srgb: np.ndarray) -> Path:
    """Write an 8-bit sRGB PNG (ISO/IEC 15948), atomically.

    Parameters
    ----------
    path
        The file.
    srgb
        ``(height, width, 3)`` display values in 0..1, clipped and rounded.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    pixels = np.rint(np.clip(srgb, 0.0, 1.0) * 255.0).astype(np.uint8)[::-1]
    height, width, _ = pixels.shape
    # Each scan line starts with its filter type, 0: none.
    lines = np.concatenate([np.zeros((height, 1), np.uint8), pixels.reshape(height, -1)], axis=1)

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    content = b"\x89PNG\r\n\x1a\n"
    content += chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    content += chunk(b"sRGB", b"\0")
    content += chunk(b"IDAT", zlib.compress(lines.tobytes(), 6))
    content += chunk(b"IEND", b"")
    with atomic_path(path) as temporary:
        temporary.write_bytes(content)
    return Path(path)


def write_exr(path: str | os.PathLike[str], rgb: np.ndarray) -> Path:
    """Write ``(height, width, 3)`` linear RGB as 32-bit floats, atomically; values of any size and sign.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {"RGB": np.ascontiguousarray(rgb[::-1], np.float32)}
    with atomic_path(path) as temporary:
        write_image(temporary, header, channels)
    return Path(path)
