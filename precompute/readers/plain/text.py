# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrices of numbers as text, with the units in a header, and lists of points on a grid.

Rows go from the top of the scan to its bottom. The header is `text_header`'s, the cells are
`text_table`'s, and `points` tells lists of points, profiles and rows of coordinates from heights.
Several channels may stand one after the other, each with its header.
"""

from __future__ import annotations

import codecs
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.limits import check_shape, check_text
from ..common.units import metres_per
from .points import Columns, columns_of, on_grid, refuse_list, without_coordinates
from .text_header import KNOWN, Header, key_of, read_header
from .text_table import Style, matrix, style_of
from .wyko_text import MAGIC as WYKO
from .wyko_text import read_wyko_text

EXTENSIONS = (".txt", ".csv", ".tsv", ".dat", ".asc", ".ascii", ".text")
_LONGEST_HEADER_LINES = 1000
_COMMENTS = ("#", "%", "//")


@dataclass
class _Block:
    """A header and the rows under it."""

    head: list[str]
    rows: list[str] = field(default_factory=list)


def read_text(path: Path) -> list[Channel]:
    """The channels of a text file: matrices, or a list of points on a grid."""
    check_text(path)
    text = _decoded(path.read_bytes())
    if text.startswith(WYKO):
        return read_wyko_text(text)
    lines = text.splitlines()
    del text
    style = style_of(line for line in lines[: 2 * _LONGEST_HEADER_LINES] if not line.lstrip().startswith(_COMMENTS))
    return [_channel(block, style) for block in _blocks(lines, style)]


def _decoded(raw: bytes) -> str:
    for mark, encoding in (
        (codecs.BOM_UTF32_LE, "utf-32"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
        (codecs.BOM_UTF8, "utf-8-sig"),
    ):
        if raw.startswith(mark):
            return raw.decode(encoding, "replace")
    start = raw[:4096]
    if b"\0" in start:
        # Without a mark: Latin letters and digits have a zero in every other byte.
        for first, encoding in ((1, "utf-16-le"), (0, "utf-16-be")):
            if start[first::2].count(0) > 0.9 * len(start[first::2]) and start[1 - first :: 2].count(0) == 0:
                return raw.decode(encoding, "replace")
        raise ScanError("The file looks binary although its name says text; export the heights as a matrix of numbers.")
    try:
        return raw.decode("utf-8")
    except UnicodeDecodeError:
        return raw.decode("latin-1")


def _blocks(lines: list[str], style: Style) -> list[_Block]:
    blocks = [_Block([])]
    for number, line in enumerate(lines):
        stripped = line.strip()
        if not stripped:
            # A row of empty cells only is a row of missing points, if heights are around it.
            if style.separator is not None and style.separator in line and blocks[-1].rows:
                blocks[-1].rows.append(line)
            continue
        comment = stripped.startswith(_COMMENTS) or (stripped.startswith(";") and style.separator != ";")
        if not blocks[-1].rows:
            if number > _LONGEST_HEADER_LINES:
                break
            if comment or style.numbers(line) is None:
                blocks[-1].head.append(line)
            else:
                blocks[-1].rows.append(line)
        elif not comment:
            blocks[-1].rows.append(line)
        elif key_of(line) in KNOWN:
            blocks.append(_Block([line]))
    found = [block for block in blocks if block.rows]
    if not found:
        raise ScanError("The text file holds no matrix of numbers; export the heights as rows of numbers.")
    return found


def _channel(block: _Block, style: Style) -> Channel:
    header = read_header(block.head)
    columns = None
    if block.head and key_of(block.head[-1]) is None:
        columns = style.cells(block.head[-1].strip().lstrip("#%/ "))
    unit = header.unit
    if unit is None and columns is not None and not header.is_map:
        named = columns_of(columns)
        z = named.index("z")
        unit = None if z is None else named.units[z]
    return Channel(header.name, unit, partial(_load, block.rows, style, header, columns))


def _load(rows: list[str], style: Style, header: Header, words: list[str] | None) -> Samples:
    values = matrix(rows, style)
    notes: list[str] = []
    if style.decimal_comma:
        notes.append("commas were read as decimal signs")
    for mark in header.no_data:
        values[values == mark] = np.nan
    if header.rows and header.cols and values.size == header.rows * header.cols:
        values = values.reshape(header.rows, header.cols)
    if not header.is_map:
        words = words if words is not None and len(words) == values.shape[1] else None
        numbers = None if words is None else [_number(word, style) for word in words]
        if words is not None and numbers is not None and not any(number is None for number in numbers[1:]):
            # "y, 0, 1, 2": a word or nothing above the first column, places along x above the others.
            values = values[:, 1:]
            notes.append("the coordinates in the first row and column were left out")
        else:
            named = columns_of(words) if words is not None else None
            listed = _listed(values, named, header, notes)
            if listed is not None:
                return listed
            values, left_out = without_coordinates(values)
            if left_out is not None:
                notes.append(f"the coordinates in the {left_out} were left out")
            if left_out == "first column" and values.shape[1] <= 8 and values.shape[0] >= 4 * values.shape[1]:
                refuse_list((values.shape[0], values.shape[1] + 1))  # several spectra over one axis
        if (values.shape[1] <= 3 and values.shape[0] > values.shape[1] > 1) or (_left_one(values) and notes):
            refuse_list(values.shape)
    check_shape(*values.shape)
    size_m = header.size_m(*values.shape)
    return Samples(values[::-1] * header.factor, size_m, np.isnan(values[::-1]), notes=tuple(notes))


def _left_one(values: np.ndarray) -> bool:
    """Whether one row or column is left: a profile under its coordinates."""
    return min(values.shape) < 2


def _number(word: str, style: Style) -> float | None:
    try:
        value = style.number(word)
    except ValueError:
        return None
    return value if value == value else None


def _listed(values: np.ndarray, named: Columns | None, header: Header, notes: list[str]) -> Samples | None:
    """A list of points as a map; None where the table is a matrix.

    Raises
    ------
    ScanError
        If the columns are a profile's, a spectrum's or scattered points'.
    """
    rows, cols = values.shape
    at = (0, 1, 2)
    if named is not None and named.is_table:
        found = tuple(named.index(name) for name in "xyz")
        if None in found:
            refuse_list(values.shape, named.names)
        at = found  # type: ignore[assignment]
    elif cols < 3 or rows < 4 or (cols > 3 and rows < 2 * cols):
        return None
    grid = on_grid(*(values[:, index] for index in at))
    if grid is None:
        if named is not None and named.is_table:
            refuse_list(values.shape, named.names)
        return None
    notes.append("the points x y z were put on their grid, y upwards")
    if cols > 3:
        notes.append(f"{cols - 3} further columns were left out")
    units = [header.unit_x, header.unit_y]
    if named is not None:
        units = [named.units[index] or unit for index, unit in zip(at[:2], units, strict=True)]
    per_x, per_y = (metres_per(unit) for unit in units)
    size_m = None if per_x is None or per_y is None else (grid.side_x * per_x, grid.side_y * per_y)
    return Samples(grid.values, size_m, np.isnan(grid.values), notes=tuple(notes))
