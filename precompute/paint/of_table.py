# SPDX-License-Identifier: GPL-3.0-or-later
"""A paint for a table: what its sidecar says of period, coherence window and headroom is filled in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..errors import ParameterError
from .maps import Paint
from .recipes import RECIPES, make_paint

#: Names of presets' parameters that are a grating's period, micrometres.
_PERIODS = ("period_um", "track_pitch_um", "row_period_um", "ridge_period_um")


def table_period(info: dict[str, Any]) -> float | None:
    """Period of the structure that a table was baked from, metres; None where its sidecar does not tell.

    Parameters
    ----------
    info
        The sidecar.
    """
    for step in info.get("source", {}).get("processing", []):
        parameters = step.get("parameters") or {}
        for name in _PERIODS:
            if step.get("step") == "preset" and name in parameters:
                return float(parameters[name]) * 1e-6
    return None


def paint_of_table(
    name: str,
    info: dict[str, Any],
    pixels: int = 1024,
    size_m: float = 0.05,
    pictures: Sequence[np.ndarray] = (),
    period_m: float | None = None,
    **settings: Any,
) -> Paint:
    """`make_paint` for a table.

    Parameters
    ----------
    name
        One of ``RECIPES``.
    info
        The table's sidecar: its period, ``sigma_s_um`` and ``headroom`` hold where they are not given.
    pixels, size_m, pictures
        As for `make_paint`.
    period_m
        The table's grating period, metres.
    **settings
        The recipe's.

    Raises
    ------
    ParameterError
        As `make_paint`, or if nobody tells the period.
    """
    if period_m is None:
        period_m = table_period(info)
    if period_m is None:
        raise ParameterError("The table does not say the period of its structure; give the period.")
    known = {setting.name for setting in RECIPES[name].settings} if name in RECIPES else set()
    filled = {"headroom": info["layout"].get("scale_headroom", 1.0)}
    sigma_s = info.get("parameters", {}).get("sigma_s_m")
    if sigma_s:
        filled["sigma_s_um"] = sigma_s * 1e6
    settings = {**{key: value for key, value in filled.items() if key in known}, **settings}
    return make_paint(name, period_m, pixels, size_m, pictures, **settings)
