# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of numbers that are no matrix of heights: points on a grid are put there, the rest is told apart.

A list of points x y z in any order becomes a map where x and y take evenly spaced values; y grows
upwards. A profile, a spectrum or a force curve is a table too, but no map.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ...errors import ScanError
from ..common.limits import check_shape

#: Coordinates of a grid may differ from even spacing by this part of a step: they were rounded.
_TOLERANCE = 0.05
#: At least this part of the grid's points must be there; a scattered cloud fills far less.
_LEAST_FILLED = 0.5


@dataclass(frozen=True)
class Grid:
    """Heights on a grid, row 0 at the bottom, NaN where no point lies; sides in the unit of the coordinates."""

    values: np.ndarray
    side_x: float
    side_y: float


def on_grid(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> Grid | None:
    """The points as a map, or None where they lie on no regular grid.

    Parameters
    ----------
    x, y, z
        ``(n,)`` coordinates and heights in any order; points with a missing coordinate are left out.
    """
    known = np.isfinite(x) & np.isfinite(y)
    x, y, z = x[known], y[known], z[known]
    if x.size < 4:
        return None
    cols, step_x = _places(x)
    rows, step_y = _places(y)
    if cols is None or rows is None:
        return None
    shape = int(rows.max()) + 1, int(cols.max()) + 1
    flat = rows * shape[1] + cols
    if min(shape) < 2 or x.size < _LEAST_FILLED * shape[0] * shape[1] or np.unique(flat).size != x.size:
        return None
    check_shape(*shape)
    values = np.full(shape[0] * shape[1], np.nan)
    values[flat] = z
    return Grid(values.reshape(shape), step_x * shape[1], step_y * shape[0])


def _places(values: np.ndarray) -> tuple[np.ndarray | None, float]:
    """Which step of an even spacing each value is, from 0, and the step; None where there is none."""
    levels = np.unique(values)
    span = float(levels[-1] - levels[0])
    if not (np.isfinite(span) and span > 0):
        return None, 0.0
    gaps = np.diff(levels)
    # Values that differ by rounding or by the stage's noise are one level; a line or two may be missing between levels.
    step = float(np.median(gaps[gaps > 0.3 * gaps.max()]))
    count = round(span / step)
    if not 1 <= count <= 10 * values.size:
        return None, 0.0
    step = span / count
    places = np.rint((values - levels[0]) / step)
    if np.abs((values - levels[0]) / step - places).max() > _TOLERANCE:
        return None, 0.0
    return places.astype(np.int64), step


@dataclass(frozen=True)
class Columns:
    """Names and units of a table's columns, from the line above it."""

    names: tuple[str, ...]
    units: tuple[str | None, ...]

    def index(self, name: str) -> int | None:
        """The column of a coordinate, ``x``, ``y`` or ``z``."""
        for number, word in enumerate(self.names):
            if word == name or (name == "z" and word in ("height", "topography", "topo")):
                return number
        return None

    @property
    def is_table(self) -> bool:
        """Whether the columns are different quantities, not places along x."""
        stems = {re.sub(r"[\d\s._-]+", "", name) for name in self.names}
        return len(self.names) > 1 and "" not in self.names and len(stems) > 1


def columns_of(cells: list[str]) -> Columns:
    """Words such as ``x [um]``, ``y (um)``, ``Z/nm``."""
    names, units = [], []
    for cell in cells:
        match = re.match(r"^\s*([^\[\](/]*?)\s*(?:[\[(/]\s*([^\])]*?)\s*[\])]?)?\s*$", cell)
        word = (match[1] if match else cell).casefold().strip(" _-:")
        names.append(re.sub(r"^(?:pos(?:ition)?|coord(?:inate)?)[ _-]*([xyz])$|^([xyz])[ _-]*(?:pos.*|coord.*|axis)?$",
                            lambda m: m[1] or m[2], word))  # fmt: skip
        units.append(match[2] if match and match[2] else None)
    return Columns(tuple(names), tuple(units))


def without_coordinates(values: np.ndarray) -> tuple[np.ndarray, str | None]:
    """A matrix without a first row or column that holds coordinates or numbers of lines, and what was left out."""
    corner = np.isnan(values[0, 0])
    row = min(values.shape) > 1 and _is_axis(
        values[0, 1:] if corner else values[0], values[1:, 1:] if corner else values[1:]
    )
    col = min(values.shape) > 1 and _is_axis(
        values[1:, 0] if corner or row else values[:, 0], (values[1:, 1:] if corner or row else values[:, 1:]).T
    )
    if not (row or col):
        both = min(values.shape) > 3 and _even(values[0, 1:]) and _even(values[1:, 0])
        row = col = both and not _alike(values[0, 1:], values[1:, 1:])
    if corner and row != col:  # an empty corner belongs to both, or is a missing point
        row = col = False
    if not (row or col):
        return values, None
    what = "first row and column" if row and col else "first row" if row else "first column"
    return values[int(row) :, int(col) :], what


def _is_axis(line: np.ndarray, body: np.ndarray) -> bool:
    """Whether a line numbers the others' places: 0, 1, 2 ... or an even spacing, which the others do not share."""
    if line.size < 3 or body.shape[0] < 1 or not _even(line) or _alike(line, body):
        return False
    numbered = line[0] in (0.0, 1.0) and abs(line[1] - line[0] - 1.0) < 1e-9
    return bool(numbered or line.size >= 8)


def _even(line: np.ndarray) -> bool:
    """Strictly monotone and evenly spaced to rounding."""
    steps = np.diff(line)
    return bool(
        line.size > 1 and np.isfinite(line).all() and steps[0] != 0 and np.abs(steps / steps[0] - 1.0).max() < 1e-4
    )


def _alike(line: np.ndarray, body: np.ndarray) -> bool:
    """Whether the lines of ``body`` climb as ``line`` does: a ramp of heights, no coordinates."""
    return bool(np.nanmax(np.abs(np.diff(body, axis=1) - np.diff(line)[None, :]), initial=0.0) < 1e-6 * np.ptp(line))


def refuse_list(shape: tuple[int, int], names: tuple[str, ...] = ()) -> None:
    """Refuse a table that is no map.

    Raises
    ------
    ScanError
        Always.
    """
    rows, cols = shape
    what = f" ({', '.join(names)[:80]})" if any(names) else ""
    kind = (
        "points off any regular grid" if cols == 3 else "a profile, a spectrum or a curve" if cols == 2 else "columns"
    )
    raise ScanError(
        f"The text holds {rows} rows of {cols} numbers{what}: {kind}, no map of heights; export the height map as a "
        "matrix or as .gsf."
    )
