# SPDX-License-Identifier: GPL-3.0-or-later
"""Channels of a scan file, and the choice of the one that holds heights."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...errors import ScanError
from .units import metres_per


@dataclass(frozen=True)
class Samples:
    """What a reader hands over for one channel.

    Parameters
    ----------
    values
        ``(rows, cols)`` numbers in the channel's unit, row 0 at the *bottom*; or what ``decode`` makes such numbers of.
    size_m
        Side lengths along x and y in metres, None where the file does not tell.
    missing
        ``(rows, cols)`` bool, or None.
    full_scale
        The value that stands for the user's height range (255, 65535, 1.0), None where the
        range is that of the values themselves.
    metadata
        Free keys: ``instrument``, ``date`` ...
    decode
        Makes numbers in the channel's unit of ``values``, point by point, NaN where a point is missing; None where
        they are such numbers. It is called with the part that is wanted, so that a huge scan is not decoded whole.
    notes
        What the user should know of the reading, each one sentence without a full stop.
    trusted
        True where the project itself wrote the file, so that its size was asked about before.
    """

    values: np.ndarray
    size_m: tuple[float, float] | None = None
    missing: np.ndarray | None = None
    full_scale: float | None = None
    metadata: dict[str, Any] = field(default_factory=dict)
    decode: Callable[[np.ndarray], np.ndarray] | None = None
    notes: tuple[str, ...] = ()
    trusted: bool = False


@dataclass(frozen=True)
class Channel:
    """Name and unit of a channel, and how to load it.

    Parameters
    ----------
    name, unit
        As the file calls them; ``unit`` is None where the file gives none.
    load
        Reads the values; called for the chosen channel only.
    """

    name: str
    unit: str | None
    load: Callable[[], Samples]

    def __post_init__(self) -> None:
        # A damaged file may call a channel anything; menus and messages get printable words.
        object.__setattr__(self, "name", _printable(self.name) or "Channel")
        if self.unit is not None:
            object.__setattr__(self, "unit", _printable(self.unit))

    @property
    def label(self) -> str:
        """Name and unit, for messages and menus."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def _printable(word: str) -> str:
    return "".join(letter if letter.isprintable() else " " for letter in word).strip()[:80]


#: Names of height channels, best first: the sensor's own height beats the drive voltage's.
_HEIGHT_NAMES = (
    r"^z[- ]?(axis ?)?sensor|^height ?\(?sensor|^measured ?height|^height ?\(?measured",
    r"^(topo|topography|height|z[- ]?axis|z height)\b|^height",
    r"topo|height|z[ -]?sensor|^z\b",
)
_BACKWARD = re.compile(r"retrace|backward|\bbwd\b|right to left", re.IGNORECASE)
_NO_HEIGHT = re.compile(r"error|amplitude|deflection|friction|phase", re.IGNORECASE)


def _rank(channel: Channel) -> tuple[int, int, int]:
    name = channel.name.strip()
    by_name = next(
        (i for i, pattern in enumerate(_HEIGHT_NAMES) if re.search(pattern, name, re.IGNORECASE)), len(_HEIGHT_NAMES)
    )
    return bool(_NO_HEIGHT.search(name)), by_name, bool(_BACKWARD.search(name))


def choose_channels(channels: Sequence[Channel], wanted: str | None, scaled: bool) -> list[Channel]:
    """The one channel that the user names, else the height channels, best first.

    Parameters
    ----------
    channels
        All channels of the file, in its order.
    wanted
        Name (case does not matter) or number from 0; None chooses by unit (a length), then by
        name, then forward before backward.
    scaled
        True when the user gave a height range, so that a channel without unit will do.

    Raises
    ------
    ScanError
        If there is no such channel or none holds heights.
    """
    offer = ", ".join(channel.label for channel in channels)
    if not channels:
        raise ScanError("The file holds no image channel; export the height channel of the scan.")
    if wanted:
        for match in (
            lambda c: c.name == wanted or c.label == wanted,
            lambda c: c.name.casefold() == wanted.strip().casefold(),
        ):
            for channel in channels:
                if match(channel):
                    return [channel]
        if wanted.strip().isdecimal() and int(wanted) < len(channels):
            return [channels[int(wanted)]]
        raise ScanError(f"The scan has no channel '{wanted}'; choose one of: {offer}.")
    heights = [channel for channel in channels if metres_per(channel.unit) is not None]
    unknown = [channel for channel in channels if not channel.unit]
    if heights:
        return sorted(heights, key=_rank)
    if unknown and scaled:
        return sorted(unknown, key=_rank)
    if unknown:
        raise ScanError(
            f"The heights of channel {unknown[0].name} carry no unit; give the height range, e.g. --height-nm 800."
        )
    raise ScanError(f"No channel of the file is a height in metres, only {offer}; export the height channel.")
