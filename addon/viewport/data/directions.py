# SPDX-License-Identifier: GPL-3.0-or-later
"""Where to look for the surroundings: a table's densities of directions in the memory of the GPU."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ....precompute.errors import DiffractionError
from .blocks import buffer
from .readings import Readings, table_stamp
from .textures import find_directions


class Directions:
    """Textures by the path of their table."""

    def __init__(self) -> None:
        self._held: dict[Path, tuple[tuple, Any]] = {}
        self._readings = Readings(find_directions)

    def texture(self, path: Path, wait: bool = False) -> Any:
        """The texture, or None while its numbers are looked for in a thread, and where they cannot be read.

        Parameters
        ----------
        wait
            Find them now.
        """
        stamp = table_stamp(path)
        held = self._held.get(path)
        if held is not None and held[0] == stamp:
            return held[1]
        try:
            image = self._readings.take(path, stamp, wait)
        except DiffractionError:
            return None  # the table's own reader says what is wrong
        if image is None:
            return None
        self._held[path] = held = (stamp, _upload(image))
        return held[1]

    def keep(self, paths: set[Path]) -> None:
        """Drop all but these."""
        self._readings.keep(paths)
        for path in self._held.keys() - paths:
            del self._held[path]

    def clear(self) -> None:
        """Drop all."""
        self._held.clear()
        self._readings.clear()


def _upload(image: np.ndarray) -> Any:
    import gpu

    texels = np.ones((*image.shape[:2], 4), np.float32)
    texels[..., :3] = image
    return gpu.types.GPUTexture((image.shape[1], image.shape[0]), format="RGBA32F", data=buffer(texels))
