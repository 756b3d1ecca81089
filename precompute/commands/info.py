# SPDX-License-Identifier: GPL-3.0-or-later
"""Say what a scan holds: shape, size, heights, channel."""

from __future__ import annotations

import argparse
from typing import Any

from . import options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """FILE, its units and the part to look at."""
    options.add_scan(parser)
    options.add_crop(parser)


def run(args: argparse.Namespace) -> dict[str, Any]:
    """See `precompute.scan.info.scan_info`; and the default coherence window of each ensemble, and what limits it."""
    from ..bake.window import coherence
    from ..scan.clipping import crop
    from ..scan.info import scan_info

    field, wanted = options.read(args), options.crop(args)
    if wanted is not None and "cropped_m" not in field.metadata:
        field = crop(field, wanted[:2], wanted[2:])
    windows = {name: coherence(field, name, None).to_json() for name in ("average", "single")}
    return {**scan_info(field), "coherence": windows}


def describe(result: dict[str, Any]) -> str:
    """In micrometres and nanometres."""
    rows, cols = result["shape"]
    x, y = (1e6 * side for side in result["size_m"])
    low, high, rms = (1e9 * result[key] for key in ("z_min_m", "z_max_m", "rms_m"))
    return "\n".join(
        (
            f"{result['format']}, channel {result['channel']}",
            f"{cols} x {rows} pixels, {x:.6g} um x {y:.6g} um",
            f"heights {low:.6g} to {high:.6g} nm, rms {rms:.6g} nm",
            f"{result['missing']} missing points",
            *(
                f"coherence {name} {1e6 * window['sigma_s_m']:.4g} um ({window['limit']})"
                for name, window in result["coherence"].items()
            ),
        )
    )
