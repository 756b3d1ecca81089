# SPDX-License-Identifier: GPL-3.0-or-later
"""Where to look for the surroundings: a table's densities of directions in the memory of the GPU."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ....precompute.errors import DiffractionError
from .blocks import buffer
from .display import redraw
from .textures import find_directions, table_stamp


class Directions:
    """Textures by the path of their table."""

    def __init__(self) -> None:
        self._held: dict[Path, tuple[tuple, Any]] = {}
        self._found: dict[Path, tuple[tuple, np.ndarray | None]] = {}
        self._threads: dict[Path, threading.Thread] = {}

    def texture(self, path: Path, wait: bool = False) -> Any:
        """The texture, or None while its numbers are looked for in a thread.

        Parameters
        ----------
        wait
            Find them now.
        """
        stamp = table_stamp(path)
        held = self._held.get(path)
        if held is not None and held[0] == stamp:
            return held[1]
        found = self._found.pop(path, None)
        if found is None or found[0] != stamp:
            if not wait:
                self._look(path, stamp)
                return None
            found = (stamp, find_directions(path))
        texture = _upload(found[1]) if found[1] is not None else None
        self._held[path] = (stamp, texture)
        return texture

    def keep(self, paths: set[Path]) -> None:
        """Drop all but these."""
        for path in self._held.keys() - paths:
            del self._held[path]

    def clear(self) -> None:
        """Drop all."""
        self._held.clear()
        self._found.clear()

    def _look(self, path: Path, stamp: tuple) -> None:
        running = self._threads.get(path)
        if running is not None and running.is_alive():
            return

        def work() -> None:
            try:
                self._found[path] = (stamp, find_directions(path))
            except DiffractionError:
                self._found[path] = (stamp, None)  # the table's own reader says what is wrong

        thread = self._threads[path] = threading.Thread(target=work, daemon=True)
        thread.start()

        def poll() -> float | None:
            if thread.is_alive():
                return 0.1
            self._threads.pop(path, None)
            redraw()
            return None

        bpy.app.timers.register(poll, first_interval=0.1)


def _upload(image: np.ndarray) -> Any:
    import gpu

    texels = np.ones((*image.shape[:2], 4), np.float32)
    texels[..., :3] = image
    return gpu.types.GPUTexture((image.shape[1], image.shape[0]), format="RGBA32F", data=buffer(texels))
