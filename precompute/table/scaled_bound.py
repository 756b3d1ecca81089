# SPDX-License-Identifier: GPL-3.0-or-later
"""What single wavelengths ask of the energy of a surface stretched by s and deepened by q, kept in a table's sidecar.

A table holds X, Y and Z and no single wavelengths, so that its bake leaves the *bounds* (`precompute.bake.energy`) of a
few (s, q) under ``energy.scaled_bound``: ``shape`` of scales, depths, polar angles and azimuths, and ``data``, the
base64 text of a zlib stream of little-endian 16-bit numbers, thousandths of the bound above 1. Scales are `SCALES` and
depths `DEPTHS` times the largest that the table holds; shallower surfaces are nearly mirrors and ask for nothing.
"""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

#: Scales over the largest that the table holds.
SCALES = 2.0 ** -np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0])

#: Depths over the largest that the table holds.
DEPTHS = (1.0, 0.6)

#: Azimuths, and the viewer's polar angles in radians: closer to each other towards the horizon.
N_AZIMUTHS = 12
THETAS = np.radians(88.0) * np.sin(np.linspace(0.0, 0.5 * np.pi, 16))

_SHAPE = (len(SCALES), len(DEPTHS), len(THETAS), N_AZIMUTHS)

#: Largest bound that is kept: beyond it a surface shows next to nothing in any case.
_MOST = 1.0 + 0.001 * 65535


def pack(bound: np.ndarray) -> dict[str, Any]:
    """The sidecar's entry of bounds ``(scales, depths, thetas, azimuths)``."""
    numbers = np.rint(1000.0 * (np.clip(bound, 1.0, _MOST) - 1.0)).astype("<u2")
    return {"shape": list(_SHAPE), "data": base64.b64encode(zlib.compress(numbers.tobytes(), 9)).decode("ascii")}


def unpack(info: dict[str, Any]) -> np.ndarray | None:
    """``(scales, depths, thetas, azimuths)`` of a sidecar; None where an older bake left none, or it is damaged."""
    entry = info.get("energy", {}).get("scaled_bound")
    if not isinstance(entry, dict) or entry.get("shape") != list(_SHAPE):
        return None
    try:
        data = zlib.decompress(base64.b64decode(entry["data"], validate=True))
        return 1.0 + 0.001 * np.frombuffer(data, "<u2").reshape(_SHAPE)
    except (KeyError, TypeError, ValueError, zlib.error):
        return None


def between(bound: np.ndarray, scale: float) -> np.ndarray:
    """``(depths, thetas, azimuths)`` at a scale over the largest, linear in its logarithm."""
    at = np.log2(SCALES)[::-1]
    place = float(np.interp(np.log2(max(scale, 1e-9)), at, np.arange(len(at))[::-1]))
    lower = min(int(place), len(SCALES) - 2)
    return bound[lower] * (1.0 - (place - lower)) + bound[lower + 1] * (place - lower)
