# SPDX-License-Identifier: GPL-3.0-or-later
"""Digital Surf files (.sur) of MountainsMap: a binary header of 512 bytes, then integers, top row first.

A height is ``count * z spacing`` in the z unit; the count ``zmin - 2`` marks a missing point where
the header says that there are such points.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...errors import ScanError
from ..common.binary import read_head, read_matrix, text, unpack
from ..common.channel import Channel, Samples
from ..common.units import metres_per

# format, objects, version, type, object name, instrument, material, acquisition, range, special, absolute, -, bits,
# zmin, zmax, cols, rows, points, dx, dy, dz, axis names, units of the spacings
_HEAD = "<12s4H30s30s5H8sH4iI3f16s16s16s16s16s16s"
_INVERSION_AT = 290
_COMMENT_SIZES_AT = 334
_HEADER_BYTES = 512


def read_sur(path: Path) -> list[Channel]:
    """The one surface of a .sur file."""
    head = read_head(path, _HEADER_BYTES)
    if head.startswith(b"DSCOMPRESSED"):
        raise ScanError("The .sur file is compressed; save it uncompressed or export it as .x3p.")
    fields = unpack(_HEAD, head)
    special, bits, zmin = fields[10], fields[13], fields[14]
    cols, rows, dx, dy, dz = fields[16], fields[17], *fields[19:22]
    name, (unit_x, unit_y, unit_z) = text(fields[24]), (_unit(raw) for raw in fields[25:28])
    if bits not in (16, 32):
        raise ScanError(f"The .sur file holds values of {bits} bits; only 16 and 32 are understood.")
    if metres_per(unit_x) is None or metres_per(unit_y) is None:
        raise ScanError(f"The .sur file measures x and y in {unit_x} and {unit_y}, which are no lengths.")
    (inversion,) = unpack("<H", head, _INVERSION_AT)
    comment, private = unpack("<HH", head, _COMMENT_SIZES_AT)
    size_m = (cols * dx * metres_per(unit_x), rows * dy * metres_per(unit_y))
    metadata = {"instrument": text(fields[6]) or "Digital Surf", "fast_axis": "x"}

    def load() -> Samples:
        counts = read_matrix(path, f"<i{bits // 8}", rows, cols, _HEADER_BYTES + comment + private)
        missing = counts == zmin - 2 if special == 1 else None
        values = counts.astype(np.float64) * (-dz if inversion in (1, 2, 3) else dz)
        axes = {2: (slice(None, None, -1), slice(None, None, -1)), 3: (slice(None), slice(None))}
        index = axes.get(inversion, (slice(None, None, -1), slice(None)))
        return Samples(values[index], size_m, None if missing is None else missing[index], metadata=metadata)

    return [Channel(name or "Height", unit_z, load)]


def _unit(raw: bytes) -> str:
    return raw.split(b"\0")[0].replace(b"\xe6", b"u").decode("latin-1").strip()
