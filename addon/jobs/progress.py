# SPDX-License-Identifier: GPL-3.0-or-later
"""What is being computed right now, for panels and status bar.

Not a property: undo must not bring a finished computation back, nor a file save it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Running:
    """A computation at work.

    Parameters
    ----------
    text
        What it is doing.
    fraction
        How much is done, 0 to 1.
    owner
        The operator at work, by its name in ``bpy.ops``; its button gives way to the progress.
    """

    text: str
    fraction: float
    owner: str = ""


_now: Running | None = None


def running() -> Running | None:
    """The computation at work, if any."""
    return _now


def show(text: str, fraction: float, owner: str = "") -> None:
    """Something is being computed."""
    global _now
    _now = Running(text, min(max(fraction, 0.0), 1.0), owner)


def clear() -> None:
    """Nothing is."""
    global _now
    _now = None
