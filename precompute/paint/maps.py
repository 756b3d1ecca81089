# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of a painted surface, in memory and in one EXR image."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..constants import LEAST_SCALE
from ..errors import OutputError, ParameterError
from ..files.atomic import atomic_path
from ..files.exr import write_image

#: Header attribute that carries the recipe.
_TEXT = "diffractionPaint"


@dataclass(eq=False)
class Paint:
    """What stands where on a painted surface.

    Parameters
    ----------
    scale
        ``(rows, cols)`` period over the table's period; row 0 at the *bottom* of the picture.
    depth
        ``(rows, cols)`` depth over the table's depth.
    rotation
        ``(rows, cols)`` radians by which the structure is turned from the tangent towards the bitangent, in [0, 2 pi).
    mask
        ``(rows, cols)`` from 0 (no structure) to 1.
    info
        The recipe and what it could not show, ready for JSON.
    """

    scale: np.ndarray
    depth: np.ndarray
    rotation: np.ndarray
    mask: np.ndarray
    info: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        maps = np.broadcast_arrays(*(np.asarray(m, np.float32) for m in self.maps))
        if maps[0].ndim != 2:
            raise ParameterError("A paint takes maps of rows and columns.")
        if not all(np.isfinite(m).all() for m in maps):
            raise ParameterError("A paint holds values that are no numbers; check the recipe's sizes.")
        scale, depth, rotation, mask = maps
        self.scale, self.depth = np.maximum(scale, LEAST_SCALE), np.maximum(depth, LEAST_SCALE)
        turn = np.float32(2.0 * np.pi)
        self.rotation = np.where((turned := np.mod(rotation, turn)) >= turn, np.float32(0), turned)
        self.mask = np.clip(mask, 0.0, 1.0)

    @property
    def maps(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Scale, depth, rotation and mask."""
        return self.scale, self.depth, self.rotation, self.mask

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.scale.shape  # type: ignore[return-value]

    @property
    def most(self) -> tuple[float, float]:
        """Largest scale and depth where there is structure: what a table's headroom must hold."""
        there = self.mask > 0
        if not there.any():
            return LEAST_SCALE, LEAST_SCALE
        return float(self.scale[there].max()), float(self.depth[there].max())


def save_paint(paint: Paint, path: str | Path) -> Path:
    """Write a paint as one EXR of 32-bit floats: R scale, G depth, B rotation in radians, A mask.

    The image is for *closest* lookups: a mean of the angles 1 and 359 degrees would point the wrong way. Where its
    texels are smaller than a pixel the renderer's samples average the light instead.

    Raises
    ------
    OutputError
        If the name does not end in ``.exr`` or the folder cannot be written.
    """
    import OpenEXR

    path = Path(path)
    if path.suffix.lower() != ".exr":
        raise OutputError(f"Cannot write '{path}': a paint is stored as .exr; give the file that suffix.")
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        _TEXT: json.dumps(paint.info, sort_keys=True, allow_nan=False),
    }
    pixels = np.ascontiguousarray(np.stack(paint.maps, axis=-1)[::-1], np.float32)
    with atomic_path(path) as temporary:
        write_image(temporary, header, {"RGBA": pixels})
    return path


def load_paint(path: str | Path) -> Paint:
    """Read what `save_paint` wrote.

    Raises
    ------
    ParameterError
        If the file is no such image.
    """
    import OpenEXR

    try:
        with OpenEXR.File(os.fspath(path)) as image:
            pixels = image.channels()["RGBA"].pixels[::-1]
            info = json.loads(image.header().get(_TEXT, ""))
    except Exception as error:  # the library raises bare exceptions of several kinds
        raise ParameterError(f"{Path(path).name} is no paint of this extension; make it again.") from error
    scale, depth, rotation, mask = np.moveaxis(pixels, -1, 0)
    return Paint(scale, depth, rotation, mask, info)
