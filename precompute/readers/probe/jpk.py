# SPDX-License-Identifier: GPL-3.0-or-later
"""JPK image scans (.jpk): a TIFF whose pages are channels, scaled by calibration slots in private tags.

The first page is a thumbnail and carries the grid (0x8042, 0x8043: side lengths in metres); each
further page has a name (0x8052), and slots of 0x30 tags from 0x8090 on: name, encoder unit (+0x12),
kind of scaling (+0x13), factor (+0x14) and offset (+0x15). The default slot (0x8081) gives the
calibrated values. Rows go from the bottom up unless the grid is reflected (0x8045).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.tiff_page import decoded, open_tiff

GRID_WIDTH = 0x8042
_GRID_HEIGHT, _GRID_REFLECT = 0x8043, 0x8045
_RETRACE, _NAME, _SLOTS, _DEFAULT = 0x8051, 0x8052, 0x8080, 0x8081
_FIRST_SLOT, _SLOT_STRIDE = 0x8090, 0x30
_MOST_SLOTS = 64


def read_jpk(path: Path) -> list[Channel]:
    """All channels of a JPK image."""
    channels = []
    with open_tiff(path) as file:
        pages = list(file.pages)
        grid = pages[0].tags
        size_m = _number(grid, GRID_WIDTH), _number(grid, _GRID_HEIGHT)
        reflected = bool(_value(grid, _GRID_REFLECT, 0))
        for index, page in enumerate(pages):
            name = _value(page.tags, _NAME, None)
            if not name:
                continue
            factor, offset, unit = _scaling(page.tags)
            if _value(page.tags, _RETRACE, 0):
                name = f"{name} (retrace)"
            channels.append(Channel(str(name), unit, partial(_load, path, index, factor, offset, size_m, reflected)))
    return channels


def _load(
    path: Path, index: int, factor: float, offset: float, size_m: tuple[float, float], reflected: bool
) -> Samples:
    with open_tiff(path) as file:
        counts = np.squeeze(decoded(file.pages[index], path))
    if counts.ndim != 2:
        raise ScanError("The JPK page holds more than one value a pixel; export it as .gwy or .gsf.")
    values = counts.astype(np.float64) * factor + offset
    return Samples(values[::-1] if reflected else values, size_m, metadata={"instrument": "JPK", "fast_axis": "x"})


def _scaling(tags: Any) -> tuple[float, float, str | None]:
    """Factor, offset and unit of the default slot."""
    wanted = _value(tags, _DEFAULT, "")
    for slot in range(min(int(_value(tags, _SLOTS, 0)), _MOST_SLOTS)):
        base = _FIRST_SLOT + slot * _SLOT_STRIDE
        if _value(tags, base, None) != wanted:
            continue
        unit = _value(tags, base + 0x12, None)
        kind = _value(tags, base + 0x13, None)
        if kind == "LinearScaling":
            return _number(tags, base + 0x14), float(_value(tags, base + 0x15, 0.0)), unit
        if kind in ("NullScaling", None):
            return 1.0, 0.0, unit
        raise ScanError(f"The JPK file scales its heights by '{kind}', which is not understood; export it as .gwy.")
    return 1.0, 0.0, "counts"


def _value(tags: Any, code: int, default: Any) -> Any:
    tag = tags.get(code)
    return default if tag is None else tag.value


def _number(tags: Any, code: int) -> float:
    value = _value(tags, code, None)
    if not isinstance(value, (int, float)):
        raise ScanError(f"The JPK file lacks the number of tag {code:#x}; copy or export it again.")
    return float(value)
