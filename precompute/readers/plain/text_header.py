# SPDX-License-Identifier: GPL-3.0-or-later
"""What the header of a text export says: of size, units, counts and the mark of missing points.

Understood are Gwyddion's keys in the languages of its menus (``# Width: 10 um``, ``# Breite: 10,0 um``), WSxM's
(``X Amplitude: 600 nm``), SPIP's (``# x-length = 2000``, nanometres unless ``x-unit`` says otherwise), Nova's
(``Scale X = 0.02``, ``Unit X = um``), those of ESRI grids (``NODATA_value -9999``) and plain ``key=value unit`` pairs.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass, field

from ..common.units import metres_per

_NUMBER = r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
_PAIR = re.compile(rf"^\s*({_NUMBER})\s*(.*?)\s*$")
_ESRI = re.compile(r"^\s*(ncols|nrows|cellsize|nodata_value|[xy]ll(?:corner|center))\s+(\S+)\s*$", re.IGNORECASE)

_SIZE_X = {
    "width", "x amplitude", "x size", "size x", "x range", "x scan size", "xreal", "scan width", "x length", "x-length",
    "breite", "anchura", "ancho", "largeur", "larghezza", "largura", "šířka", "ширина", "幅", "폭",
}  # fmt: skip
_SIZE_Y = {
    "height", "y amplitude", "y size", "size y", "y range", "y scan size", "yreal", "scan height", "y length",
    "y-length", "höhe", "altura", "alto", "hauteur", "altezza", "výška", "высота", "高さ", "높이",
}  # fmt: skip
_SIZE = {"scan size", "size"}
_STEP_X = {"x pixel size", "pixel size x", "pixel width", "dx", "x step", "x spacing", "scale x", "x-scale"}
_STEP_Y = {"y pixel size", "pixel size y", "pixel height", "dy", "y step", "y spacing", "scale y", "y-scale"}
_STEP = {"pixel size", "step", "pixelsize"}
_UNIT = {
    "value units", "value unit", "data unit", "data units", "z unit", "z units", "zunit", "zunits", "z-unit",
    "z-units", "height unit", "unit data", "jednotky hodnot", "einheiten", "einheit", "werteinheiten",
    "einheiten der werte", "unités", "unités de valeur", "unités des valeurs", "unità valore", "unidades de valor",
    "unidades", "unidades del valor", "値の単位", "값 단위", "единицы измерения",
}  # fmt: skip
_UNIT_OF_NUMBER = {"z amplitude", "z range", "z scale"}
_UNIT_X = {"x-unit", "x unit", "xunit", "unit x", "xy units", "xy-unit", "xyunits"}
_UNIT_Y = {"y-unit", "y unit", "yunit", "unit y"}
_NAME = {"channel", "title", "channel name", "kanal", "kanál", "canal", "canale", "канал", "チャネル", "채널"}
_COLS = {"ncols", "x-pixels", "nx", "columns", "number of columns", "w"}
_ROWS = {"nrows", "y-pixels", "ny", "rows", "number of rows", "h"}
_NO_DATA = {"nodata_value", "nodata", "no data", "no data value", "missing value", "bad value", "invalid value"}

#: Keys in words, of a file with several channels one after the other: a new header begins.
KNOWN = _SIZE_X | _SIZE_Y | _UNIT | _NAME


@dataclass
class Header:
    """What a header says; lengths in metres, None where it is silent."""

    name: str = "Height"
    unit: str | None = None
    factor: float = 1.0
    size_x: float | None = None
    size_y: float | None = None
    step_x: float | None = None
    step_y: float | None = None
    rows: int | None = None
    cols: int | None = None
    no_data: list[float] = field(default_factory=list)
    unit_x: str | None = None
    unit_y: str | None = None

    @property
    def is_map(self) -> bool:
        """Whether the numbers below are surely a matrix of heights."""
        sized = self.size_x is not None and self.size_y is not None
        return sized or self.step_x is not None or (self.rows is not None and self.cols is not None)

    def size_m(self, rows: int, cols: int) -> tuple[float, float] | None:
        """Side lengths of a matrix of this shape."""
        x = self.size_x if self.size_x is not None else self.step_x and self.step_x * cols
        y = self.size_y if self.size_y is not None else self.step_y and self.step_y * rows
        # A negative or zero size is the user's to correct, so it is handed on, not dropped.
        return None if x is None or y is None else (x, y)


def key_of(line: str) -> str | None:
    """The key of a header line, None where it is no pair."""
    match = re.match(r"([^:=：]+)[:=：]", _bare(line))
    return " ".join(match[1].casefold().split()) if match else None


def read_header(lines: list[str]) -> Header:
    """The header in these lines."""
    pairs = []
    for line in lines:
        esri = _ESRI.match(line)
        if esri:
            pairs.append((esri[1].casefold(), esri[2]))
            continue
        bare = _bare(line)
        # "h=305 w=75" is several pairs in one line; elsewhere the first ':' or '=' separates.
        several = re.findall(r"\b([hw])=(\d{1,9})\b", bare)
        if several:
            pairs += several
        match = re.match(r"([^:=：]+)[:=：](.*)$", bare)
        if match:
            pairs.append((" ".join(match[1].casefold().split()), match[2].strip()))
    header = Header()
    for key, value in pairs:  # first, since numbers may stand before their unit
        if key in _UNIT_X:
            header.unit_x = value.split()[0] if value else None
        elif key in _UNIT_Y:
            header.unit_y = value.split()[0] if value else None
    spip = ("file format", "ascii") in [(key, value.casefold()) for key, value in pairs]
    if spip:
        header.unit_x = header.unit_x or "nm"
    header.unit_y = header.unit_y or header.unit_x
    for key, value in pairs:
        _take(header, key, value, spip)
    return header


def _bare(line: str) -> str:
    return unicodedata.normalize("NFC", line.strip().lstrip("#%;/ \t"))[:500]


def decimal(text: str) -> float:
    """A number with a dot or a comma."""
    return float(text.replace(",", "" if "." in text else "."))


def _take(header: Header, key: str, value: str, spip: bool) -> None:
    pair = _PAIR.match(value)
    if key in _NAME and value:
        header.name = value
    elif key in _UNIT and value:
        header.unit = value
    elif key in _UNIT_OF_NUMBER and pair and pair[2] and header.unit is None:
        header.unit = pair[2]
    elif key in _NO_DATA and pair:
        header.no_data.append(decimal(pair[1]))
    elif key == "bit2nm" and pair and spip and header.unit is None:
        header.unit, header.factor = "nm", decimal(pair[1])
    elif key in _COLS and pair and re.fullmatch(r"\d{1,9}", pair[1]):
        header.cols = int(pair[1])
    elif key in _ROWS and pair and re.fullmatch(r"\d{1,9}", pair[1]):
        header.rows = int(pair[1])
    elif pair:
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
                    unit = pair[2] or (header.unit_y if name.endswith("_y") else header.unit_x)
                    factor = metres_per(unit)
                    if factor is not None:
                        setattr(header, name, decimal(pair[1]) * factor)
