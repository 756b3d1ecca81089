# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers of a table that a drawing cannot wait for: read in a thread, and the view drawn again when they are there."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy

from ....precompute.files.stamp import file_stamp
from .display import redraw


def table_stamp(path: Path) -> tuple:
    """What changes when a table is baked again; empty where a file is missing."""
    stamps = [file_stamp(path.with_suffix(suffix)) for suffix in (".exr", ".json")]
    return () if None in stamps else tuple(stamps)


class Readings:
    """What a function reads of tables, by their paths; each is given away once.

    Parameters
    ----------
    read
        Reads one. Runs in a thread: it must not touch Blender. What it raises, `take` does.
    """

    def __init__(self, read: Callable[[Path], Any]) -> None:
        self._read = read
        self._found: dict[Path, tuple[tuple, Any]] = {}
        self._threads: dict[Path, threading.Thread] = {}

    def take(self, path: Path, stamp: tuple, wait: bool) -> Any:
        """What was read, or None while a thread reads.

        Parameters
        ----------
        stamp
            Of the file as it is; what was read of another is forgotten.
        wait
            Read now.

        Raises
        ------
        Exception
            As of the function; again and again, till the file changes.
        """
        if wait:
            self._found.pop(path, None)
            return self._read(path)
        found = self._found.get(path)
        if found is None or found[0] != stamp:
            self._start(path, stamp)
            return None
        value = found[1]
        if isinstance(value, Exception):
            raise value.with_traceback(None)
        del self._found[path]
        return value

    def keep(self, paths: set[Path]) -> None:
        """Drop all but these."""
        for path in self._found.keys() - paths:
            del self._found[path]

    def clear(self) -> None:
        """Drop all."""
        self._found.clear()

    def _start(self, path: Path, stamp: tuple) -> None:
        if path in self._threads:
            return

        def work() -> None:
            try:
                self._found[path] = stamp, self._read(path)
            except Exception as error:
                self._found[path] = stamp, error

        thread = self._threads[path] = threading.Thread(target=work, daemon=True)
        thread.start()

        def poll() -> float | None:
            if thread.is_alive():
                return 0.05
            self._threads.pop(path, None)
            redraw()
            return None

        bpy.app.timers.register(poll, first_interval=0.05, persistent=True)
