# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrices of numbers as text, with the units in a header.

Understood are the headers of Gwyddion (``# Width: 10 um``, ``# Height: 10 um``,
``# Value units: m``), WSxM (``X Amplitude: 600 nm``, ``Z Amplitude: 20 nm``) and plain
``key=value unit`` pairs (``pixel size=3.7e-7 m``, ``data unit=nm``). Rows go from the top of the
scan to its bottom.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.limits import check_shape, check_text
from ..common.units import metres_per

EXTENSIONS = (".txt", ".csv", ".tsv", ".dat", ".asc", ".ascii", ".text")
_LONGEST_HEADER_LINES = 1000
_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_PAIR = re.compile(rf"^\s*({_NUMBER})\s*(.*?)\s*$")

_SIZE_X = {"width", "x amplitude", "x size", "size x", "x range", "x scan size", "xreal", "scan width", "x length"}
_SIZE_Y = {"height", "y amplitude", "y size", "size y", "y range", "y scan size", "yreal", "scan height", "y length"}
_SIZE = {"scan size", "size"}
_STEP_X = {"x pixel size", "pixel size x", "pixel width", "dx", "x step", "x spacing"}
_STEP_Y = {"y pixel size", "pixel size y", "pixel height", "dy", "y step", "y spacing"}
_STEP = {"pixel size", "step", "pixelsize"}
_UNIT = {"value units", "value unit", "data unit", "data units", "z unit", "z units", "zunit", "zunits", "height unit"}
_UNIT_OF_NUMBER = {"z amplitude", "z range", "z scale"}
_NAME = {"channel", "title", "channel name"}


@dataclass
class _Header:
    name: str = "Height"
    unit: str | None = None
    size_x: float | None = None
    size_y: float | None = None
    step_x: float | None = None
    step_y: float | None = None


def read_text(path: Path) -> list[Channel]:
    """The one channel of a text matrix."""
    check_text(path)
    raw = path.read_bytes()
    if b"\0" in raw[:4096]:
        raise ScanError("The file looks binary although its name says text; export the heights as a matrix of numbers.")
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    del raw
    lines = text.splitlines()
    first = _first_row(lines)
    header = _read_header(lines[:first])
    rows = [line for line in lines[first:] if line.strip() and not line.lstrip().startswith(("#", "%", ";", "//"))]

    def load() -> Samples:
        values = _matrix(rows)
        size_x = header.size_x or (header.step_x and header.step_x * values.shape[1])
        size_y = header.size_y or (header.step_y and header.step_y * values.shape[0])
        # A negative or zero size is the user's to correct, so it is handed on, not dropped.
        size_m = None if size_x is None or size_y is None else (size_x, size_y)
        return Samples(values[::-1], size_m)

    return [Channel(header.name, header.unit, load)]


def _first_row(lines: list[str]) -> int:
    for index, line in enumerate(lines[:_LONGEST_HEADER_LINES]):
        pieces = _split(line)
        if pieces and all(_is_number(piece) for piece in pieces):
            return index
    raise ScanError("The text file holds no matrix of numbers; export the heights as rows of numbers.")


def _split(line: str) -> list[str]:
    return [piece for piece in re.split(r"[\s;,]+", line.strip()) if piece]


def _is_number(piece: str) -> bool:
    try:
        float(piece)
    except ValueError:
        return False
    return True


def _read_header(lines: list[str]) -> _Header:
    header = _Header()
    for line in lines:
        line = line.strip().lstrip("#%;/ \t")[:500]
        # "h=305 w=75" is several pairs in one line; elsewhere the first ':' or '=' separates.
        match = re.match(r"([^:=]+)[:=](.*)$", line)
        if not match:
            continue
        key, value = " ".join(match[1].casefold().split()), match[2].strip()
        pair = _PAIR.match(value)
        length = None
        if pair and (factor := metres_per(pair[2])) is not None:
            length = float(pair[1]) * factor
        if key in _NAME and value:
            header.name = value
        elif key in _UNIT and value:
            header.unit = value
        elif key in _UNIT_OF_NUMBER and pair and pair[2] and header.unit is None:
            header.unit = pair[2]
        elif length is not None:
            for keys, names in (
                (_SIZE_X, ("size_x",)),
                (_SIZE_Y, ("size_y",)),
                (_SIZE, ("size_x", "size_y")),
                (_STEP_X, ("step_x",)),
                (_STEP_Y, ("step_y",)),
                (_STEP, ("step_x", "step_y")),
            ):
                if key in keys:
                    for name in names:
                        setattr(header, name, length)
    return header


def _matrix(rows: list[str]) -> np.ndarray:
    """Numbers of all rows as ``(rows, cols)``; as many in each row."""
    sample = rows[0]
    if ";" in sample or "\t" in sample.strip() or " " in sample.strip():
        decimal_comma = "," in sample and "." not in sample and not re.search(r",\s", sample)
    else:
        decimal_comma = False
    if decimal_comma:
        rows = [line.replace(",", ".") for line in rows]
    rows = [re.sub(r"[;,]", " ", line) if (";" in line or "," in line) else line for line in rows]
    check_shape(len(rows), len(rows[0].split()))
    try:
        values = np.loadtxt(rows, dtype=np.float64, comments=None, ndmin=2)
    except ValueError as error:
        raise ScanError(f"The text matrix is not rectangular or holds words ({_first_clause(error)}).") from None
    if not np.isfinite(values).all():
        row, col = np.argwhere(~np.isfinite(values))[0]
        raise ScanError(
            f"The text matrix holds nan or inf in row {row + 1}, column {col + 1}; "
            "export it with the missing points filled, or as .gsf."
        )
    return values


def _first_clause(error: Exception) -> str:
    return str(error).split(";")[0].split("\n")[0][:120].strip().rstrip(".")
