# SPDX-License-Identifier: GPL-3.0-or-later
"""Functions on Blender's lists of handlers: each once, and only those lists that this Blender has."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import bpy

#: Name of a list of `bpy.app.handlers`, and what is called.
Handlers = Iterable[tuple[str, Callable[..., None]]]


def add(handlers: Handlers) -> None:
    """Let Blender call them."""
    for name, handler in handlers:
        where = getattr(bpy.app.handlers, name, None)
        if where is not None and handler not in where:
            where.append(handler)


def remove(handlers: Handlers) -> None:
    """Let it call them no more."""
    for name, handler in handlers:
        where = getattr(bpy.app.handlers, name, None)
        if where is not None and handler in where:
            where.remove(handler)
