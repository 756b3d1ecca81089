# SPDX-License-Identifier: GPL-3.0-or-later
"""Native Gwyddion files (.gwy), versions 1 (GWYO) and 2 (GWYP).

A tree of typed components (Gwyddion user guide, "Gwyddion Native Format"); version 1 differs in
its outermost container, whose items begin with a GType number in place of a letter behind the
name, and in strings of any encoding. The walk below
checks every length against the bytes that are there and goes into the containers that matter
only, so damaged files end in one sentence and never in a long loop.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.binary import contents
from ..common.channel import Channel, Samples
from ..common.limits import check_shape

MAGIC = (b"GWYO", b"GWYP")
_SCALARS = {"b": "<B", "c": "<c", "i": "<i", "q": "<q", "d": "<d"}
_ARRAYS = {"C": 1, "I": 4, "Q": 8, "D": 8}
#: GLib's fundamental types (number * 4) as they stand in containers of version 1.
_GTYPES = {12: "c", 16: "c", 20: "b", 24: "i", 28: "i", 40: "q", 44: "q", 60: "d", 64: "s", 80: "o"}
_DAMAGED = "The .gwy file is damaged or cut short; copy or export it again."


def read_gwy(path: Path) -> list[Channel]:
    """All image channels of a .gwy file, in the order of their numbers."""
    data = contents(path)
    name, body, _ = _object(data, 4)
    if name != "GwyContainer":
        raise ScanError(_DAMAGED)
    items = dict(_components(body, "/", numbered=data[:4] == b"GWYO"))
    channels = []
    numbers = sorted(int(match[1]) for key in items if (match := re.fullmatch(r"/(\d{1,9})/data", key)))
    for number in numbers:
        field = _field(items[f"/{number}/data"])
        if field is None:
            continue
        title = items.get(f"/{number}/data/title")
        mask = _field(items.get(f"/{number}/mask"))
        name = title if isinstance(title, str) and title.strip() else f"Channel {number}"
        channels.append(Channel(name, _base_unit(field.get("si_unit_z")), partial(_load, field, mask)))
    return channels


def _field(item: Any) -> dict[str, Any] | None:
    """The components of a data field, or None where ``item`` is something else."""
    if not (isinstance(item, tuple) and item[0] == "GwyDataField"):
        return None
    return dict(_components(item[1], ""))


def _load(field: dict[str, Any], mask: dict[str, Any] | None) -> Samples:
    values = _values(field)
    x, y = field.get("xreal"), field.get("yreal")
    known = isinstance(x, float) and isinstance(y, float) and _base_unit(field.get("si_unit_xy")) == "m"
    missing = None
    if mask is not None:
        marked = _values(mask)
        # A mask of all pixels marks nothing apart; it is a leftover of the session.
        if marked.shape == values.shape and not (marked >= 0.5).all():
            missing = marked >= 0.5
    return Samples(values, (x, y) if known else None, missing, decode=np.asarray)  # type: ignore[arg-type]


def _values(field: dict[str, Any]) -> np.ndarray:
    rows, cols, data = field.get("yres"), field.get("xres"), field.get("data")
    if not (isinstance(rows, int) and isinstance(cols, int) and isinstance(data, memoryview)):
        raise ScanError(_DAMAGED)
    check_shape(rows, cols)
    if len(data) != 8 * rows * cols:
        raise ScanError(_DAMAGED)
    return np.frombuffer(data, "<f8").reshape(rows, cols)[::-1]


def _base_unit(item: Any) -> str | None:
    """The unit without its prefix: Gwyddion stores values in base units whatever prefix the string shows."""
    if not (isinstance(item, tuple) and item[0] == "GwySIUnit"):
        return None
    text = dict(_components(item[1], "")).get("unitstr")
    if not isinstance(text, str) or not text.strip():
        return None
    text = text.strip()
    return "m" if len(text) <= 2 and text.endswith("m") else text


def _object(data: memoryview, start: int) -> tuple[str, memoryview, int]:
    """Name, body and end of the object at ``start``."""
    name, at = _string(data, start, 256)
    (size,) = _unpack("<I", data, at)
    end = at + 4 + size
    if end > len(data):
        raise ScanError(_DAMAGED)
    return name, data[at + 4 : end], end


def _components(data: memoryview, prefix: str, numbered: bool = False) -> Iterator[tuple[str, Any]]:
    """Name and value of each component; objects as ``(type name, body)``, arrays as their bytes.

    ``prefix`` keeps only the keys that start with it; ``numbered`` reads a container of version 1.
    """
    at = 0
    while at < len(data):
        if numbered:
            code = _GTYPES.get(_unpack("<I", data, at)[0], "?")
            key, at = _string(data, at + 4, 4096)
        else:
            key, at = _string(data, at, 4096)
            if at >= len(data):
                raise ScanError(_DAMAGED)
            code = chr(data[at])
            at += 1
        value: Any = None
        if code in _SCALARS:
            (value,) = _unpack(_SCALARS[code], data, at)
            at += struct.calcsize(_SCALARS[code])
        elif code == "s":
            value, at = _string(data, at, 1 << 24)
        elif code == "o":
            name, body, at = _object(data, at)
            value = (name, body)
        elif code in _ARRAYS:
            (count,) = _unpack("<I", data, at)
            value = data[at + 4 : at + 4 + count * _ARRAYS[code]]
            at += 4 + count * _ARRAYS[code]
        elif code in "SO":
            (count,) = _unpack("<I", data, at)
            at += 4
            if count > len(data) - at:  # each item takes one byte at least
                raise ScanError(_DAMAGED)
            for _ in range(count):
                at = _string(data, at, 1 << 24)[1] if code == "S" else _object(data, at)[2]
        else:
            raise ScanError(_DAMAGED)
        if at > len(data):
            raise ScanError(_DAMAGED)
        if key.startswith(prefix):
            yield key, value


def _string(data: memoryview, start: int, longest: int) -> tuple[str, int]:
    """A zero-terminated string and the position behind it."""
    # In growing pieces: a search in the whole rest would make a copy of it for each short name.
    length = 64
    while True:
        piece = bytes(data[start : start + length])
        end = piece.find(b"\0")
        if end >= 0:
            text = piece[:end]
            break
        if length > len(data) - start or length > longest:
            raise ScanError(_DAMAGED)
        length *= 8
    try:
        return text.decode("utf-8"), start + end + 1
    except UnicodeDecodeError:  # version 1 wrote the locale's bytes, a lone 0xb5 for micro
        return text.decode("latin-1"), start + end + 1


def _unpack(layout: str, data: memoryview, at: int) -> tuple[Any, ...]:
    if at + struct.calcsize(layout) > len(data):
        raise ScanError(_DAMAGED)
    return struct.unpack_from(layout, data, at)
