# SPDX-License-Identifier: GPL-3.0-or-later
"""What the extension has to say without being asked: in its panel where there is a window, else on the console."""

from __future__ import annotations

import bpy

_said: list[str] = []


def say(text: str) -> None:
    """Tell a sentence, without its full stop; the panel keeps it until another file is loaded."""
    if bpy.app.background:
        print(f"Diffraction: {text}.")
    elif text not in _said:
        _said.append(text)


def said() -> tuple[str, ...]:
    """What the panel shows."""
    return tuple(_said)


def clear() -> None:
    """Another file: nothing that was said is true of it."""
    _said.clear()
