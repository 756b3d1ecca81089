# SPDX-License-Identifier: GPL-3.0-or-later
"""Which tags a TIFF carries: microscopes' dialects of TIFF are told apart by their private tags."""

from __future__ import annotations

import struct
from pathlib import Path

_MOST_TAGS = 4096


def first_tags(path: Path) -> set[int]:
    """Codes of all tags of the first page of a classic TIFF; empty where the file is none or is damaged."""
    with open(path, "rb") as file:
        head = file.read(8)
        order = {b"II*\0": "<", b"MM\0*": ">"}.get(head[:4])
        if order is None or len(head) < 8:
            return set()
        file.seek(struct.unpack(order + "I", head[4:])[0])
        count = file.read(2)
        if len(count) < 2:
            return set()
        entries = file.read(12 * min(struct.unpack(order + "H", count)[0], _MOST_TAGS))
    return {struct.unpack_from(order + "H", entries, at)[0] for at in range(0, len(entries) - 11, 12)}
