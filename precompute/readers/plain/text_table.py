# SPDX-License-Identifier: GPL-3.0-or-later
"""Rows of text as numbers: separators, decimal commas, quotes, and cells that hold no number.

A cell that is empty between two separators, or says NaN, NA, Bad or the like, is a missing point and
keeps its place; a word or an infinity elsewhere is an error.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ...errors import ScanError
from ..common.limits import check_loaded

#: Cells without a number that stand for a point without a height.
_MARKS = {
    *("", "nan", "+nan", "-nan", "na", "n/a", "#n/a", "<na>", "null", "none", "bad", "void", "invalid", "undefined"),
    *("masked", "nodata", "no data", "-", "--", "---", "*", "***"),
    *("1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind", "1.#snan"),
}
_PLAIN = re.compile(r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eEdD][-+]?\d+)?$")
_COMMA = re.compile(r"[-+]?(?:\d+(?:,\d+)?|,\d+)(?:[eEdD][-+]?\d+)?$")
_INFINITE = re.compile(r"[-+]?(?:inf(?:inity)?|1\.#inf)$", re.IGNORECASE)
_SAMPLE_LINES = 64
#: As many lines, the last of the sample, decide the style: rows may be thousands of numbers long.
_STYLE_LINES = 12


@dataclass(frozen=True)
class Style:
    """How a row is cut into cells (``separator`` None: white space), and whether a comma is the decimal sign."""

    separator: str | None
    decimal_comma: bool
    quoted: bool

    def cells(self, line: str) -> list[str]:
        """The cells of a line, bare."""
        if self.quoted:
            pieces = next(csv.reader([line.strip(" \r\n")], delimiter=self.separator or " ", skipinitialspace=True), [])
        elif self.separator is None:
            return line.split()
        else:
            pieces = line.split(self.separator)
        return [_bare(piece) for piece in pieces]

    def number(self, cell: str) -> float:
        """The number in a cell, NaN for a mark.

        Raises
        ------
        ValueError
            If it is neither.
        """
        if cell.casefold() in _MARKS:
            return np.nan
        if not (_COMMA if self.decimal_comma else _PLAIN).match(cell) and not _INFINITE.match(cell):
            raise ValueError(cell)
        if self.decimal_comma:
            cell = cell.replace(",", ".")
        return float(cell.replace("1.#", "").replace("d", "e").replace("D", "e"))

    def numbers(self, line: str) -> list[float] | None:
        """All cells of a row of numbers and marks, None where the line is no such row."""
        cells = self.cells(line)
        try:
            values = [self.number(cell) for cell in cells]
        except ValueError:
            return None
        return values if any(value == value for value in values) else None


def _bare(cell: str) -> str:
    """A cell without the quotes around it; half a pair shows that it was cut wrongly."""
    cell = cell.strip()
    return cell[1:-1].strip() if len(cell) > 1 and cell[0] == cell[-1] and cell[0] in "\"'" else cell


def style_of(lines: Iterable[str]) -> Style:
    """The style in which most of these lines are rows of numbers."""
    sample = [line for line in lines if re.search(r"\d", line)][-_STYLE_LINES:]
    best, best_score = Style(None, False, False), (-1, -1)
    for style in _STYLES:
        rows = [row for line in sample if (row := style.numbers(line)) is not None]
        widths = [len(row) for row in rows]
        common = max(set(widths), key=widths.count, default=0)
        # As many rows as can be, of one width; among equals the style that stands first.
        score = (widths.count(common) if common > 1 else 0, len(rows))
        if score > best_score:
            best, best_score = style, score
    return best


#: Tried in this order; a comma between digits is a separator only where nothing else separates.
_CUTS = (("\t", False), ("\t", True), (";", False), (";", True), (None, False), (None, True), (",", False))
_STYLES = (
    *(Style(separator, comma, quoted) for quoted in (False, True) for separator, comma in _CUTS),
    Style(",", True, True),
)


def _trimmed(line: str, style: Style) -> str:
    """Without the separator that some programs write behind the last cell."""
    line = line.strip(" \r\n") if style.separator == "\t" else line.strip()
    return line[:-1] if style.separator is not None and line.endswith(style.separator) else line


def matrix(rows: list[str], style: Style) -> np.ndarray:
    """``(rows, cols)`` numbers, NaN where a cell holds none.

    Raises
    ------
    ScanError
        If the rows are not equally long, or hold words or infinities.
    """
    full = [len(style.cells(line)) for line in rows[:_SAMPLE_LINES]]
    width = max(set(full), key=full.count)
    if style.separator is not None and all(
        line.rstrip(" \r\n").endswith(style.separator) for line in rows[:_SAMPLE_LINES]
    ):
        # A separator behind the last cell of each row is no cell; a single one is an empty cell.
        rows = [_trimmed(line, style) for line in rows]
        width -= 1
    check_loaded(len(rows), width)
    try:
        return _fast(rows, style, width)
    except ValueError:
        pass
    values = np.empty((len(rows), width))
    for index, line in enumerate(rows):
        cells = style.cells(line)
        if len(cells) != width:
            raise ScanError(
                f"The text matrix is not rectangular (row {index + 1} has {len(cells)} numbers, others {width}); "
                "export it again."
            )
        for col, cell in enumerate(cells):
            try:
                values[index, col] = style.number(cell)
            except ValueError:
                raise ScanError(
                    f"The text matrix holds '{cell[:30]}' in row {index + 1}, column {col + 1}; export rows of numbers."
                ) from None
    return _finite(values)


def _fast(rows: list[str], style: Style, width: int) -> np.ndarray:
    """By numpy's parser, which knows numbers and nan only."""
    if style.quoted:
        raise ValueError
    if style.decimal_comma:
        rows = [line.replace(",", ".") for line in rows]
    values = np.loadtxt(rows, dtype=np.float64, comments=None, ndmin=2, delimiter=style.separator)
    if values.shape != (len(rows), width):
        raise ValueError
    return _finite(values)


def _finite(values: np.ndarray) -> np.ndarray:
    infinite = np.isinf(values)
    if infinite.any():
        row, col = np.argwhere(infinite)[0]
        raise ScanError(
            f"The text matrix holds inf in row {row + 1}, column {col + 1}; export it with the missing points "
            "marked as NaN, or as .gsf."
        )
    return values
