# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scan holds, in a few numbers."""

from __future__ import annotations

from typing import Any

from .heightfield import HeightField


def scan_info(field: HeightField) -> dict[str, Any]:
    """Shape, size, heights and origin of a heightfield, ready for JSON.

    Returns
    -------
    dict
        ``shape`` (rows, cols), ``size_m`` (x, y), ``z_min_m``, ``z_max_m``, ``rms_m`` (standard
        deviation about the mean), all over the valid points; ``missing`` (their number),
        ``channel``, ``channels``, ``format``; ``notes``, one sentence each on what was chosen, assumed
        or will be filled in.
    """
    valid = field.valid
    missing = int(field.missing.sum())
    notes = list(field.metadata.get("notes", ()))
    if missing:
        notes.append(
            f"{missing} missing points ({100 * missing / field.missing.size:.2g} %) are filled from around them"
        )
    return {
        "shape": [int(count) for count in field.shape],
        "size_m": [float(size) for size in field.size_m],
        "z_min_m": float(valid.min()),
        "z_max_m": float(valid.max()),
        "rms_m": float(valid.std()),
        "channel": field.metadata.get("channel"),
        "channels": list(field.metadata.get("channels", [])),
        "missing": missing,
        "format": field.metadata.get("format"),
        "notes": notes,
    }
