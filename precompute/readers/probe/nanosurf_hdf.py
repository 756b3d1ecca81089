# SPDX-License-Identifier: GPL-3.0-or-later
"""Nanosurf Studio's files (.nhf): HDF5, of each signal one array of counts, bottom row first.

A group of a measurement or segment gives pixels and metres of its lines; a count from the least to the greatest
of its type stands for ``signal_calibration_min`` to ``signal_calibration_max`` (version 1: ``base_calibration``).
From version 2 on the least signed or greatest unsigned number marks a missing point. (As Nanosurf's own Python
package reads it.)
"""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.hdf import groups, number_of, open_hdf, values_of, word
from ..common.limits import check_loaded, check_shape

_TYPES_1 = {0: "i4", 1: "u1", 2: "u2", 3: "u4", 4: "u8", 5: "i2", 6: "i8", 7: "f8"}


def read_nhf(path: Path) -> list[Channel]:
    """The image channels of an .nhf file."""
    channels = []
    with open_hdf(path) as file:
        for group in groups(file):
            shape, size_m = _grid(group)
            for name in group:
                data = group[name]
                if shape is None or not hasattr(data, "dtype") or data.size != shape[0] * shape[1]:
                    continue
                channel = _channel(path, group, data, shape, size_m)
                if channel is not None:
                    channels.append(channel)
    if not channels:
        raise ScanError("The .nhf file holds no image (spectra, perhaps); export the topography as .gsf.")
    return channels


def _grid(group: Any) -> tuple[tuple[int, int] | None, tuple[float, float] | None]:
    """Rows and columns, and sides in metres, of a group or of the nearest group above it that says so."""
    attributes = group.attrs
    if "rect_axis_size" in attributes and np.size(attributes["rect_axis_size"]) >= 2:
        rows, cols = (int(count) for count in np.ravel(attributes["rect_axis_size"])[:2])
    else:
        found_cols = number_of(attributes, "image_points_per_line", "grid_number_of_columns")
        found_rows = number_of(attributes, "image_number_of_lines", "grid_number_of_rows")
        if found_cols is None or found_rows is None:
            return (None, None) if group.name == "/" else _grid(group.parent)
        rows, cols = int(found_rows), int(found_cols)
    check_shape(rows, cols)
    check_loaded(rows, cols)
    if "rect_axis_range" in attributes and np.size(attributes["rect_axis_range"]) >= 2:
        side_y, side_x = (float(side) for side in np.ravel(attributes["rect_axis_range"])[:2])
        return (rows, cols), (side_x, side_y)
    x, y = number_of(attributes, "image_size_x", "grid_width"), number_of(attributes, "image_size_y", "grid_height")
    return (rows, cols), None if x is None or y is None else (x, y)


def _channel(
    path: Path, group: Any, data: Any, shape: tuple[int, int], size_m: tuple[float, float] | None
) -> Channel | None:
    attributes = data.attrs
    if "dataset_element_type" not in attributes:
        return None
    kind = attributes["dataset_element_type"]
    second = isinstance(kind, (str, bytes))
    if second:
        text = word(kind)
        dtype = (
            np.dtype("f8" if text == "double" else text) if re.fullmatch(r"u?int(8|16|32|64)|double", text) else None
        )
    else:
        dtype = np.dtype(_TYPES_1[int(kind)]) if int(kind) in _TYPES_1 else None
    if dtype is None:
        return None
    prefix = "signal_calibration" if "signal_calibration_min" in attributes else "base_calibration"
    low, high = number_of(attributes, f"{prefix}_min"), number_of(attributes, f"{prefix}_max")
    unit = word(attributes.get(f"{prefix}_unit", ""))
    match = re.search(r"\(([^)]+)\)", unit)
    name = word(attributes.get("signal_name", attributes.get("name", data.name.rsplit("/", 1)[-1])))
    segment = word(group.attrs.get("segment_name", group.attrs.get("name", ""))) if group.name != "/" else ""
    load = partial(_load, path, data.name, shape, size_m, dtype, second, low or 0.0, 1.0 if high is None else high)
    return Channel(f"{name} ({segment})" if segment else name, (match[1] if match else unit) or None, load)


def _load(
    path: Path,
    name: str,
    shape: tuple[int, int],
    size_m: tuple[float, float] | None,
    dtype: np.dtype,
    second: bool,
    low: float,
    high: float,
) -> Samples:
    with open_hdf(path) as file:
        counts = values_of(path, file[name]).reshape(shape)
    if dtype.kind == "f":
        least, greatest, mark = 0.0, 1.0, None
    else:
        limits = np.iinfo(dtype)
        # Version 2 keeps one number of each type for missing points.
        least = float(limits.min) + (second and dtype.kind == "i")
        greatest = float(limits.max) - (second and dtype.kind == "u")
        mark = (limits.min if dtype.kind == "i" else limits.max) if second else None
    values = (counts.astype(np.float64) - least) * ((high - low) / (greatest - least)) + low
    missing = np.isnan(values) if mark is None else counts == mark
    return Samples(values, size_m, missing, metadata={"instrument": "Nanosurf", "fast_axis": "x"})
