# SPDX-License-Identifier: GPL-3.0-or-later
"""Omicron's flat files of MATRIX and Vernissage (.Z_flat and other channels): axes, a transfer function, then counts.

Strings are a count and UTF-16. A mirrored x axis stores each line forwards, then backwards; a mirrored y axis the scan
upwards, then downwards. The first line is the bottom. Values are ``(count - Offset) / Factor`` (``TFF_Linear1D``), or
``(Raw_1 - PreOffset) * (count - Offset) / (NeutralFactor * PreFactor)`` (``TFF_MultiLinear1D``), as access2theMatrix
has it. A scan that was stopped misses its last lines.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import contents, number, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_loaded, check_shape
from ..common.units import metres_per

MAGIC = b"FLAT0100"
_MOST = 256


class _Walk:
    """Takes values one after the other, each compared with what is there."""

    def __init__(self, data: memoryview) -> None:
        self.data, self.at = data, len(MAGIC)

    def take(self, layout: str) -> tuple:
        values = unpack(layout, self.data, self.at)
        self.at += sum({"I": 4, "i": 4, "d": 8, "Q": 8}[letter] for letter in layout[1:])
        return values

    def count(self) -> int:
        (count,) = self.take("<I")
        if count > _MOST:
            raise ScanError("The Omicron file counts more entries than there can be; copy or export it again.")
        return count

    def word(self) -> str:
        (length,) = self.take("<I")
        (raw,) = unpack(f"<{min(2 * length, len(self.data))}s", self.data, self.at)
        self.at += 2 * length
        return raw.decode("utf-16-le", "replace").rstrip("\0")


def read_flat(path: Path) -> list[Channel]:
    """The scans up and down, forward and backward, of a flat file."""
    data = contents(path)
    walk = _Walk(data)
    axes = [_axis(walk) for _ in range(walk.count())]
    name, transfer, unit = walk.word(), walk.word(), walk.word()
    values = {walk.word(): walk.take("<d")[0] for _ in range(walk.count())}
    for _ in range(walk.count()):  # kinds of views
        walk.take("<I")
    walk.take("<Q")
    walk.word()
    _, there = walk.take("<II")
    if len(axes) != 2:
        raise ScanError("The Omicron file holds spectra or curves, no image; export the topography as .gsf.")
    step, zero = _transfer(transfer, values)
    (cols, step_x, unit_x, mirrored_x), (rows, step_y, unit_y, mirrored_y) = axes
    check_shape(rows, cols)
    check_loaded(rows * (1 + mirrored_x) * (1 + mirrored_y), cols)
    per_x, per_y = metres_per(unit_x), metres_per(unit_y)
    size_m = None if per_x is None or per_y is None else (cols * abs(step_x) * per_x, rows * abs(step_y) * per_y)
    channels = []
    for down in (False, True) if mirrored_y else (False,):
        for backward in (False, True) if mirrored_x else (False,):
            first = (rows if down else 0) * (1 + mirrored_x) + backward
            rest = (1 + mirrored_x, backward, down)
            load = partial(_load, data, walk.at, there, (rows, cols), first, rest, size_m, (step, zero))
            label = f"{name} ({'down' if down else 'up'}, {'backward' if backward else 'forward'})"
            channels.append(Channel(label, unit or None, load))
    return channels


def _axis(walk: _Walk) -> tuple[int, float, str, int]:
    """Points one way, their step and its unit, and 1 where the axis is run both ways."""
    _, _, unit = walk.word(), walk.word(), walk.word()
    clocks, _, _, _, step, mirrored, tables = walk.take("<IiiddII")
    for _ in range(min(tables, _MOST)):
        walk.word()
        for _ in range(walk.count()):
            walk.take("<III")
    both = int(mirrored == 1)
    return clocks // (1 + both), step, unit, both


def _transfer(name: str, values: dict[str, float]) -> tuple[float, float]:
    """Factor and offset: ``(count - offset) * factor``."""

    def value(key: str) -> float:
        return number(values.get(key), key)

    if name == "TFF_Linear1D":
        return 1.0 / (value("Factor") or 1.0), value("Offset")
    if name == "TFF_MultiLinear1D":
        below = value("NeutralFactor") * value("PreFactor")
        return (value("Raw_1") - value("PreOffset")) / (below or 1.0), value("Offset")
    raise ScanError(f"The Omicron file scales its values by '{name[:40]}', which is not understood; export it as .gsf.")


def _load(
    data: memoryview,
    at: int,
    there: int,
    shape: tuple[int, int],
    first: int,
    rest: tuple[int, bool, bool],
    size_m: tuple[float, float] | None,
    scale: tuple[float, float],
) -> Samples:
    rows, cols = shape
    stride, backward, down = rest
    there = min(there, (len(data) - at) // 4)
    counts = np.frombuffer(data, "<i4", there, at)[: there // cols * cols].reshape(-1, cols)
    lines = counts[first::stride][:rows]
    values = np.full(shape, np.nan)
    values[: len(lines)] = (lines.astype(np.float64) - scale[1]) * scale[0]
    values = values[:: -1 if down else 1, :: -1 if backward else 1]
    return Samples(values, size_m, metadata={"instrument": "Omicron", "fast_axis": "x"}, decode=np.asarray)
