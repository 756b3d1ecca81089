# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials of the user's own: CSV files, and files of the database refractiveindex.info (.yml)."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import ParameterError
from .dispersion import Curve
from .material import Material

_LARGEST_BYTES = 2 * 1024 * 1024

#: A CSV's wavelengths are micrometres where all are below this, else nanometres.
_MICROMETRES_BELOW = 20.0

_HOW = "give two or three columns: wavelength in nm or um, n, and k if it absorbs"
_TYPE = re.compile(r"^\s*-?\s*type:\s*(\S.*)$")
_FIELD = re.compile(r"^\s*(data|coefficients|wavelength_range|range):\s*(.*)$")


def read_material(path: str | Path) -> Material:
    """A material from a file.

    Parameters
    ----------
    path
        ``.yml`` or ``.yaml``: refractiveindex.info's form (tables and formulas 1 to 9). Anything else: columns of
        wavelength, n and perhaps k; wavelengths are nanometres, or micrometres where all lie below 20.

    Raises
    ------
    ParameterError
        If it cannot be read, is no material, or is a table that does not cover 380-780 nm.
    """
    path = Path(path)
    what = f"The material's file '{path.name}'"
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise ParameterError(f"{what} is larger than 2 MB; {_HOW}.")
        raw = path.read_bytes()
    except OSError as error:
        raise ParameterError(f"{what} cannot be read ({error.strerror or error}); choose another.") from error
    if b"\0" in raw:
        raise ParameterError(f"{what} is no text; {_HOW}.")
    text = raw.decode("utf-8-sig", "replace")
    try:
        n, k = _yml(text, what) if path.suffix.lower() in (".yml", ".yaml") else _columns(text, what)
    except ParameterError as error:
        message = str(error)
        raise ParameterError(message if message.startswith("The ") else f"{what} {message}.") from None
    return Material(path.name, n, k, path.name)


def _table(rows: list[tuple[float, ...]], column: int, unit: float) -> Curve:
    return Curve("table", tuple(row[column] for row in rows), tuple(row[0] * unit for row in rows))


def _rows(lines: list[tuple[int, str]], what: str, widths: tuple[int, ...]) -> list[tuple[float, ...]]:
    rows: list[tuple[float, ...]] = []
    for number, line in lines:
        parts = [part for part in re.split(r"[;,\t ]+", line.strip()) if part]
        try:
            row = tuple(float(part) for part in parts)
        except ValueError:
            if rows:
                raise ParameterError(
                    f"{what} has no numbers in line {number} ('{line.strip()[:40]}'); {_HOW}."
                ) from None
            continue  # a header
        if row and len(row) not in widths:
            raise ParameterError(f"{what} has {len(row)} numbers in line {number}; {_HOW}.")
        if row:
            rows.append(row)
    if not rows:
        raise ParameterError(f"{what} holds no numbers; {_HOW}.")
    if len({len(row) for row in rows}) > 1:
        raise ParameterError(f"{what} has lines of two and of three numbers; {_HOW}.")
    return rows


def _columns(text: str, what: str) -> tuple[Curve, Curve | None]:
    lines = [
        (number, line)
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    rows = _rows(lines, what, (2, 3))
    unit = 1e-6 if all(abs(row[0]) < _MICROMETRES_BELOW for row in rows) else 1e-9
    return _table(rows, 1, unit), _table(rows, 2, unit) if len(rows[0]) == 3 else None


def _yml(text: str, what: str) -> tuple[Curve, Curve | None]:
    """n and k of the entries below ``DATA:``; nothing else of the file counts."""
    n: Curve | None = None
    k: Curve | None = None
    for kind, fields in _entries(text):
        if kind.startswith("formula"):
            numbers = [float(x) for x in _floats(fields.get("coefficients", []), what)]
            span = [1e-6 * x for x in _floats(fields.get("wavelength_range", fields.get("range", [])), what)]
            name = kind.split()[-1]
            if not name.isdigit():
                raise ParameterError(f"has a formula '{kind}' that is not known; formulas 1 to 9 are")
            n = Curve("formula", tuple(numbers), (), int(name), (span[0], span[1]) if len(span) == 2 else None)
        elif kind.startswith("tabulated"):
            columns = kind.split()[-1]
            rows = _rows([(number, line) for number, line in fields.get("data", [])], what, (len(columns) + 1,))
            for column, letter in enumerate(columns, 1):
                if letter == "n":
                    n = _table(rows, column, 1e-6)
                elif letter == "k":
                    k = _table(rows, column, 1e-6)
    if n is None:
        raise ParameterError("holds no refractive index; choose a file with 'tabulated nk', 'tabulated n' or a formula")
    return n, k


def _entries(text: str) -> list[tuple[str, dict[str, list[tuple[int, str]]]]]:
    """Type and fields of each entry: the lines of a field, each with its number."""
    entries: list[tuple[str, dict[str, list[tuple[int, str]]]]] = []
    inside, field, indent = False, "", 0
    for number, line in enumerate(text.splitlines(), 1):
        if re.match(r"^\S", line) and not line.lstrip().startswith(("#", "-")):
            inside, field = line.startswith("DATA:"), ""
            continue
        if not inside or not line.strip() or line.lstrip().startswith("#"):
            continue
        depth = len(line) - len(line.lstrip())
        found = _TYPE.match(line)
        if found:
            entries.append((found[1].strip().strip("\"'"), {}))
            field = ""
            continue
        found = _FIELD.match(line)
        if found and entries:
            field, indent = found[1], depth
            rest = found[2].strip()
            entries[-1][1][field] = [] if rest in ("", "|", ">", "|-") else [(number, rest)]
        elif field and entries and depth > indent:
            entries[-1][1][field].append((number, line))
        else:
            field = ""
    return entries


def _floats(lines: list[tuple[int, str]], what: str) -> list[float]:
    try:
        return [float(part) for _, line in lines for part in re.split(r"[,\s\[\]]+", line) if part]
    except ValueError:
        raise ParameterError(f"{what} has a formula whose coefficients are no numbers.") from None
