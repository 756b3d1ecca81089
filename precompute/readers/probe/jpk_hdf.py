# SPDX-License-Identifier: GPL-3.0-or-later
"""JPK's fast scans (.h5-jpk): HDF5, of each channel one column a frame, bottom row first.

``position-pattern.grid`` of a measurement gives pixels (``ilength``, ``jlength``) and metres (``ulength``,
``vlength``); ``net-encoder.scaling`` of a channel makes its default unit of counts. (As AFMReader reads it.)
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.channel import Channel, Samples
from ..common.hdf import number_of, open_hdf, values_of, word
from ..common.limits import check_loaded, check_shape

_GRID = "position-pattern.grid."
_MOST_FRAMES = 64


def read_h5_jpk(path: Path) -> list[Channel]:
    """The channels of a .h5-jpk file, frame by frame."""
    channels = []
    with open_hdf(path) as file:
        for measurement in sorted(name for name in file if name.startswith("Measurement_")):
            group = file[measurement]
            cols = number_of(group.attrs, _GRID + "ilength")
            rows = number_of(group.attrs, _GRID + "jlength")
            side_x, side_y = number_of(group.attrs, _GRID + "ulength"), number_of(group.attrs, _GRID + "vlength")
            if cols is None or rows is None or side_x is None or side_y is None:
                raise ScanError("The .h5-jpk file has no grid of pixels; export the image as .jpk or .gsf.")
            check_shape(int(rows), int(cols))
            check_loaded(int(rows), int(cols))
            for name in sorted(name for name in group if name.startswith("Channel_")):
                channels += _frames(path, group[name], (int(rows), int(cols)), (side_x, side_y))
    return channels


def _frames(path: Path, channel: object, shape: tuple[int, int], size_m: tuple[float, float]) -> list[Channel]:
    attributes = channel.attrs  # type: ignore[attr-defined]
    fancy = word(attributes.get("channel.fancy-name", attributes.get("channel.name", "Channel")))
    direction = "retrace" if word(attributes.get("retrace", "false")).casefold() == "true" else "trace"
    unit = word(attributes.get("net-encoder.scaling.unit.unit", "")) or None
    step = number_of(attributes, "net-encoder.scaling.multiplier")
    zero = number_of(attributes, "net-encoder.scaling.offset") or 0.0
    found = []
    for name in channel:  # type: ignore[attr-defined]
        data = channel[name]  # type: ignore[index]
        if name == "thumbnail" or getattr(data, "ndim", 0) != 2 or data.shape[0] != shape[0] * shape[1]:
            continue
        for frame in range(min(data.shape[1], _MOST_FRAMES)):
            label = f"{fancy} ({direction})" + (f" frame {frame + 1}" if data.shape[1] > 1 else "")
            load = partial(_load, path, data.name, frame, shape, size_m, 1.0 if step is None else step, zero)
            found.append(Channel(label, unit, load))
    return found


def _load(
    path: Path, name: str, frame: int, shape: tuple[int, int], size_m: tuple[float, float], step: float, zero: float
) -> Samples:
    with open_hdf(path) as file:
        counts = values_of(path, file[name])[:, frame].reshape(shape)
    return Samples(counts * np.float64(step) + zero, size_m, metadata={"instrument": "JPK", "fast_axis": "x"})
