# SPDX-License-Identifier: GPL-3.0-or-later
"""What a preset is: a formula with parameters, real dimensions and a source for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

#: Metres.
NM, UM = 1e-9, 1e-6


@dataclass(frozen=True)
class Parameter:
    """One parameter of a preset, as command line and panels show it.

    Parameters
    ----------
    name
        With its unit at the end (``period_um``); the flag is ``--period-um``.
    default
        A float, an int or a bool; its type is the parameter's.
    unit
        ``um``, ``nm``, ``deg``, ``percent`` or empty.
    minimum, maximum
        Limits, both allowed; None for a bool.
    help
        One sentence without a full stop.
    """

    name: str
    default: float | int | bool
    unit: str
    minimum: float | None
    maximum: float | None
    help: str

    @property
    def flag(self) -> str:
        """The command line's name of it."""
        return "--" + self.name.replace("_", "-")


def seed(what: str) -> Parameter:
    """The parameter of random structures; another number gives ``what``."""
    return Parameter("seed", 1, "", 0, 1000000, f"Another number gives {what}")


@dataclass(frozen=True)
class Preset:
    """A structure that needs no microscope.

    Parameters
    ----------
    name, label, description
        For scripts, for menus, and one sentence for the curious.
    source
        Where the dimensions come from.
    size_um, pixels
        Default side length and pixels a side.
    build
        ``build(x, y, size, values)`` returns heights in metres, ``(rows, cols)``: ``x`` and ``y`` are
        the pixel centres in metres (from the left and the bottom), ``size`` the side lengths in
        metres, ``values`` the parameters by name, in their own units.
    parameters
        In the order of menus.
    """

    name: str
    label: str
    description: str
    source: str
    size_um: float
    pixels: int
    build: Callable[[np.ndarray, np.ndarray, tuple[float, float], Mapping[str, Any]], np.ndarray]
    parameters: tuple[Parameter, ...] = ()
