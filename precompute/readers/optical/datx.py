# SPDX-License-Identifier: GPL-3.0-or-later
"""Zygo's Mx files (.datx): HDF5 with the heights of one surface, top row first.

``/MetaData`` names the surface's path; its attributes give the unit, the value of missing points (``No Data``) and the
metres a pixel (``X Converter``, ``Y Converter``). (As Gwyddion and SurfaceTopography read it.)
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.hdf import groups, number_of, open_hdf, values_of, word
from ..common.limits import check_loaded, check_shape

_LENGTHS = {"Meters": "m", "MilliMeters": "mm", "MicroMeters": "um", "NanoMeters": "nm", "Angstroms": "Ang"}


def read_datx(path: Path) -> list[Channel]:
    """The surface of a .datx file."""
    with open_hdf(path) as file:
        data = _surface(file)
        if data is None or data.ndim != 2:
            raise ScanError("The .datx file holds no surface; save the height map.")
        rows, cols = data.shape
        check_shape(rows, cols)
        check_loaded(rows, cols)
        unit = word(data.attrs.get("Unit", ""))
        steps = [_step(data.attrs.get(f"{axis} Converter")) for axis in "XY"]
        size_m = None if None in steps else (cols * steps[0], rows * steps[1])  # type: ignore[operator]
        load = partial(_load, path, data.name, size_m, number_of(data.attrs, "No Data"))
    return [Channel("Height", _LENGTHS.get(unit, unit) or None, load)]


def _surface(file: Any) -> Any:
    """By the path in /MetaData, else the dataset named Surface or the first with a Z Converter."""
    rows = file["MetaData"][()] if "MetaData" in file else []
    keys = {(word(row[0]), word(row[1])): word(row[2]) for row in rows[:10_000]}
    measurement = keys.get(("Root", "Measurement"), "")
    place = keys.get((keys.get((measurement, "Surface"), ""), "Path"))
    if place and place in file:
        return file[place]
    for group in groups(file):
        for name in group:
            if "Z Converter" in getattr(group[name], "attrs", {}) and hasattr(group[name], "dtype"):
                return group[name]
    return None


def _step(converter: Any) -> float | None:
    """Metres a pixel of a converter: category, unit, numbers of which the second is the step."""
    if converter is None:
        return None
    record = np.ravel(converter)[0]
    if word(record[0]) != "LateralCat" or word(record[1]) != "Pixels":
        return None
    step = float(np.ravel(record[-1])[1])
    return step if np.isfinite(step) and step > 0 else None


def _load(path: Path, name: str, size_m: tuple[float, float] | None, mark: float | None) -> Samples:
    with open_hdf(path) as file:
        values = values_of(path, file[name]).astype(np.float64)[::-1]
    missing = ~np.isfinite(values)
    if mark is not None:
        missing |= values == mark
    return Samples(values, size_m, missing, metadata={"instrument": "Zygo"})
