# SPDX-License-Identifier: GPL-3.0-or-later
"""Alicona's files (.al3d): tags of 52 bytes, then float32 metres, top row first, rows padded to 8 bytes.

NaN and the value of the tag ``InvalidPixelValue`` mark missing points.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number, read_head, read_matrix, text
from ..common.channel import Channel, Samples

MAGIC = b"AliconaImaging\0\r\n"
_TAG_BYTES, _KEY_BYTES, _VALUE_BYTES = 52, 20, 30
_MOST_TAGS = 1000


def read_al3d(path: Path) -> list[Channel]:
    """The depth image of an .al3d file."""
    head = read_head(path, len(MAGIC) + _TAG_BYTES * (_MOST_TAGS + 2))
    tags: dict[str, str] = {}
    at = len(MAGIC)
    while at + _TAG_BYTES <= len(head) and head[at + 50 : at + 52] == b"\r\n" and len(tags) < _MOST_TAGS:
        key, value = head[at : at + _KEY_BYTES], head[at + _KEY_BYTES : at + _KEY_BYTES + _VALUE_BYTES]
        tags[text(key)] = text(value)
        at += _TAG_BYTES
        if len(tags) >= 2 and len(tags) >= integer(tags.get("TagCount", _MOST_TAGS), "TagCount") + 2:
            break
    cols, rows = integer(tags.get("Cols"), "Cols"), integer(tags.get("Rows"), "Rows")
    start = integer(tags.get("DepthImageOffset"), "DepthImageOffset")
    if start <= 0:
        raise ScanError("The .al3d file holds a picture but no heights; export it with its depth image.")
    size_m = (
        cols * number(tags.get("PixelSizeXMeter"), "PixelSizeXMeter"),
        rows * number(tags.get("PixelSizeYMeter"), "PixelSizeYMeter"),
    )
    try:
        mark = float(tags.get("InvalidPixelValue", "nan"))
    except ValueError:
        mark = float("nan")
    metadata = {"instrument": "Alicona", "version": tags.get("CreatingApplication", "")}

    def load() -> Samples:
        values = read_matrix(path, "<f4", rows, cols + cols % 2, start)[::-1, :cols]
        return Samples(values, size_m, metadata=metadata, decode=partial(_heights, mark=mark))

    return [Channel("Height", "m", load)]


def _heights(values: np.ndarray, mark: float) -> np.ndarray:
    heights = values.astype(np.float64)
    # The tag is a decimal number, rounded: as near as float32 tells.
    heights[np.abs(heights - mark) <= 1.5e-7 * abs(mark)] = np.nan
    return heights
