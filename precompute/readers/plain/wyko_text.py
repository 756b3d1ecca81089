# SPDX-License-Identifier: GPL-3.0-or-later
"""Wyko's export as text: named blocks, of which an array has a line for each place along x, from the bottom up.

Values are nanometres where the second flag of the first line is 1, else wavelengths (``Wavelength`` in
nanometres) divided by ``Mult``; ``Bad`` marks a missing point. ``Pixel_size`` is in millimetres, ``Aspect``
stretches y.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ...errors import ScanError
from ..common.binary import integer, number
from ..common.channel import Channel, Samples
from ..common.limits import check_loaded, check_shape

MAGIC = "Wyko ASCII Data File Format"
_HEIGHTS = ("RAW_DATA", "RAW DATA", "OPD", "Raw", "SAMPLE_DATA")
_PICTURES = ("Image", "Intensity", "SecArr_0")


def read_wyko_text(text: str) -> list[Channel]:
    """The height arrays of a Wyko text file.

    Raises
    ------
    ScanError
        If size or array is missing or cut short.
    """
    lines = text.splitlines()
    flags = lines[0][len(MAGIC) :].split()
    keys: dict[str, str] = {}
    arrays: list[tuple[str, int]] = []
    at, cols = 1, 0
    while at < len(lines):
        cells = lines[at].split("\t")
        at += 1
        if len(cells) == 2:
            keys[cells[0].strip()] = cells[1].strip()
        elif len(cells) >= 3 and cells[0].strip() in _HEIGHTS + _PICTURES:
            cols = integer(keys.get("X Size"), "X Size")
            if cells[0].strip() in _HEIGHTS:
                arrays.append((cells[0].strip(), at))
            at += max(cols, 0)
        elif len(cells) >= 4:
            keys[cells[0].strip()] = cells[3].strip()
    cols, rows = integer(keys.get("X Size"), "X Size"), integer(keys.get("Y Size"), "Y Size")
    check_shape(rows, cols)
    check_loaded(rows, cols)
    factor = 1e-9
    if len(flags) < 2 or flags[1] != "1":
        factor *= number(keys.get("Wavelength"), "Wavelength") / (number(keys.get("Mult", 1), "Mult") or 1.0)
    step = abs(number(keys.get("Pixel_size"), "Pixel_size")) * 1e-3
    size_m = cols * step, rows * step * number(keys.get("Aspect", 1.0), "Aspect")

    def load(start: int) -> Samples:
        values = np.full((cols, rows), np.nan)
        for col, line in enumerate(lines[start : start + cols]):
            cells = line.split()
            if len(cells) != rows:
                raise ScanError(f"The Wyko file has {len(cells)} of {rows} values in a line; export it again.")
            values[col] = [np.nan if cell.casefold() == "bad" else number(cell, "RAW_DATA") for cell in cells]
        if len(lines) < start + cols:
            raise ScanError("The Wyko file ends early; copy or export it again.")
        values = values.T * factor
        return Samples(values, size_m, np.isnan(values), metadata={"instrument": "Wyko"})

    return [Channel(name, "m", partial(load, start)) for name, start in arrays]
