# SPDX-License-Identifier: GPL-3.0-or-later
"""Igor binary waves (.ibw, version 5) as Asylum Research's microscopes write them.

Two headers of 64 and 320 bytes, the values (x fastest, then y from the bottom up, then channels), a
note of ``key: value`` lines and the names of the channels (WaveMetrics, Technical Note PTN003).
"""

from __future__ import annotations

from functools import partial
from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples
from ..common.limits import check_shape
from ..common.units import ASSUMED_METRES, metres_per

# version, checksum, wave, formula, note, data units, units of 4 dimensions, labels of 4 dimensions, indices, options
_BIN_HEADER = "hhiiii4i4iiii"
_BIN_BYTES, _HEADER_BYTES = 64, 384
_TYPES = {2: "f4", 4: "f8", 8: "i1", 16: "i2", 32: "i4", 72: "u1", 80: "u2", 96: "u4"}
_LABEL_BYTES = 32
_MOST_LAYERS = 256

#: Units of Asylum's channels by the beginning of their names; the wave carries one unit for all.
_ASYLUM_UNITS = (
    (("height", "zsensor", "deflection", "amplitude"), "m"),
    (("phase",), "deg"),
    (("frequency",), "Hz"),
    (("current",), "A"),
)


def read_ibw(path: Path) -> list[Channel]:
    """All layers of a two- or three-dimensional wave."""
    head = read_head(path, _HEADER_BYTES)
    order = next((order for order in "<>" if unpack(order + "h", head)[0] == 5), None)
    if order is None:
        raise ScanError("The .ibw file is no Igor wave of version 5; export it as .gwy or .gsf.")
    sizes = unpack(order + _BIN_HEADER, head)
    wave, formula, note_size, data_units = sizes[2:6]
    (kind,) = unpack(order + "h", head, _BIN_BYTES + 16)
    cols, rows, layers, chunks = unpack(order + "4i", head, _BIN_BYTES + 68)
    steps = unpack(order + "4d", head, _BIN_BYTES + 84)
    unit, lateral = text(head[_BIN_BYTES + 148 :][:4]), text(head[_BIN_BYTES + 152 :][:4])
    lateral_y = text(head[_BIN_BYTES + 156 :][:4])
    if chunks > 1 or kind not in _TYPES or min(wave, formula, note_size, data_units, *sizes[6:14]) < 0:
        raise ScanError("The .ibw file holds no plain two-dimensional data; export the height image.")
    check_shape(rows, cols)
    layers = max(layers, 1)
    if layers > _MOST_LAYERS:
        raise ScanError(f"The .ibw file declares {layers} channels; copy or export it again.")
    note_at = _BIN_BYTES + wave + formula
    labels_at = note_at + note_size + data_units + sum(sizes[6:10]) + sum(sizes[10:12])
    note = _note(path, note_at, note_size)
    names = _labels(path, labels_at, sizes[12], layers)
    per_x, per_y = metres_per(lateral or "m"), metres_per(lateral_y or lateral or "m")
    size_m = None if per_x is None or per_y is None else (cols * steps[0] * per_x, rows * steps[1] * per_y)
    notes = () if lateral else (ASSUMED_METRES,)
    metadata = {
        "instrument": f"Asylum Research {note['MicroscopeModel']}" if "MicroscopeModel" in note else "Igor Pro",
        "date": f"{note.get('Date', '')} {note.get('Time', '')}".strip(),
        "fast_axis": "y" if note.get("ScanAngle", "0").strip() in ("90", "270") else "x",
    }
    item = np.dtype(_TYPES[kind]).itemsize

    def load(layer: int) -> Samples:
        values = read_matrix(path, order + _TYPES[kind], rows, cols, _HEADER_BYTES + layer * rows * cols * item)
        return Samples(values, size_m, metadata=metadata, decode=np.asarray, notes=notes)

    return [Channel(name, _unit(name, unit, note), partial(load, layer)) for layer, name in enumerate(names)]


def _unit(name: str, wave_unit: str, note: dict[str, str]) -> str | None:
    if not note:
        return wave_unit or None
    base = name.casefold().removeprefix("nap").removeprefix("dac")
    for beginnings, unit in _ASYLUM_UNITS:
        if base.startswith(beginnings):
            return unit
    return wave_unit or None if len(note) < 5 else "V"


def _note(path: Path, at: int, size: int) -> dict[str, str]:
    with open(path, "rb") as file:
        file.seek(at)
        lines = file.read(min(size, 1 << 22)).decode("latin-1").splitlines()
    return {key.strip(): value.strip() for key, colon, value in (line.partition(":") for line in lines) if colon}


def _labels(path: Path, at: int, size: int, layers: int) -> list[str]:
    """Names of the layers; the first label of a dimension names the dimension itself."""
    with open(path, "rb") as file:
        file.seek(at)
        raw = file.read(min(size, _LABEL_BYTES * (layers + 1)))
    names = [text(raw[i * _LABEL_BYTES :][:_LABEL_BYTES]) for i in range(1, layers + 1)]
    return [name or f"Layer {i}" for i, name in enumerate(names)]
