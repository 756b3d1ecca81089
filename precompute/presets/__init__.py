# SPDX-License-Identifier: GPL-3.0-or-later
"""Structures for users without a microscope.

``PRESETS`` holds them by name with everything a command line or a panel needs; ``make_preset``
builds one. A new preset is one more entry in the ``PRESETS`` tuple of a module listed below, and a line in
``LOOKS``, the table of what suits each.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import ParameterError, SizeLimitError
from ..scan.heightfield import HeightField
from . import bumps, coated, discs, foils, gratings, morpho, snake
from .looks import LOOKS, Look, look_of
from .preset import Parameter, Preset

__all__ = ["LOOKS", "PRESETS", "Look", "Parameter", "Preset", "look_of", "make_preset"]

#: Files of Blender keep a preset's number in this order: new ones go to the end.
PRESETS: dict[str, Preset] = {
    preset.name: preset
    for module in (snake, gratings, discs, foils, morpho, bumps, coated)
    for preset in module.PRESETS
}

#: Most pixels a side.
LIMIT_PIXELS = 8192


def make_preset(
    name: str,
    size_m: float | tuple[float, float] | None = None,
    pixels: int | None = None,
    **parameters: Any,
) -> HeightField:
    """Build the heightfield of a preset.

    Parameters
    ----------
    name
        One of ``PRESETS``.
    size_m
        Side length in metres, one for a square or (x, y); None takes the preset's own.
    pixels
        Pixels along x (square pixels along y); None keeps the pixel size of the preset's defaults.
    **parameters
        The preset's parameters in the units their names carry, e.g. ``period_um=2.0``.

    Returns
    -------
    HeightField
        Pixel (r, c) has its centre at ``((c + 1/2) dx, (r + 1/2) dy)``.

    Raises
    ------
    ParameterError
        If the preset or a parameter is not known or a value is out of its limits.
    SizeLimitError
        If the patch would have more than 8192 pixels a side.
    """
    preset = PRESETS.get(name)
    if preset is None:
        raise ParameterError(f"There is no preset '{name}'; choose one of {', '.join(PRESETS)}.")
    values = _checked(preset, parameters)
    size = _size(preset, size_m)
    cols, rows = _pixels(preset, size, pixels)
    dx, dy = size[0] / cols, size[1] / rows
    heights = preset.build((np.arange(cols) + 0.5) * dx, (np.arange(rows) + 0.5) * dy, size, values)
    metadata = {
        "name": name,
        "format": "preset",
        "channel": "Height",
        "channels": ["Height [m]"],
        "description": preset.description,
        "source": preset.source,
    }
    return HeightField(
        heights, dx, dy, metadata=metadata, processing=({"step": "preset", "name": name, "parameters": values},)
    )


def _checked(preset: Preset, given: dict[str, Any]) -> dict[str, Any]:
    known = {parameter.name: parameter for parameter in preset.parameters}
    unknown = [name for name in given if name not in known]
    if unknown:
        has = f"has {', '.join(known)}" if known else "has none"
        raise ParameterError(f"Preset '{preset.name}' has no parameter {unknown[0]}; it {has}.")
    return {name: _value(parameter, given.get(name)) for name, parameter in known.items()}


def _value(parameter: Parameter, given: Any) -> float | int | bool:
    if given is None:
        return parameter.default
    if isinstance(parameter.default, bool):
        return bool(given)
    try:
        value = float(given)
    except (TypeError, ValueError):
        value = math.nan
    low = -math.inf if parameter.minimum is None else parameter.minimum
    high = math.inf if parameter.maximum is None else parameter.maximum
    if not low <= value <= high:
        unit = f" {parameter.unit}" if parameter.unit else ""
        raise ParameterError(f"{parameter.name} is {given}; give a number from {low:g} to {high:g}{unit}.")
    return int(value) if isinstance(parameter.default, int) else value


def _size(preset: Preset, size_m: float | tuple[float, float] | None) -> tuple[float, float]:
    if size_m is None:
        return preset.size_um * 1e-6, preset.size_um * 1e-6
    x, y = (float(side) for side in np.broadcast_to(np.asarray(size_m, float), 2))
    if not all(math.isfinite(side) and side > 0 for side in (x, y)):
        raise ParameterError(f"The size {size_m} m makes no sense; give positive side lengths.")
    return x, y


def _pixels(preset: Preset, size: tuple[float, float], pixels: int | None) -> tuple[int, int]:
    if pixels is None:
        pixels = max(2, math.ceil(size[0] / (preset.size_um * 1e-6) * preset.pixels - 1e-9))
    cols, rows = int(pixels), max(1, round(int(pixels) * size[1] / size[0]))
    if min(cols, rows) < 2:
        raise ParameterError(f"{cols} x {rows} pixels are no heightfield; give at least 2 a side.")
    if max(cols, rows) > LIMIT_PIXELS:
        raise SizeLimitError(
            f"The patch would have {cols} x {rows} pixels, above the limit of {LIMIT_PIXELS} a side; "
            "choose a smaller size or fewer pixels."
        )
    return cols, rows
