# SPDX-License-Identifier: GPL-3.0-or-later
"""Half-float RGB images in OpenEXR files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from .errors import TableError


def write_half_rgb(path: str | Path, pixels: np.ndarray) -> None:
    """Write ``(height, width, 3)`` float16 pixels; row 0 of the array is the *bottom* of the picture.

    Uncompressed: half-float speckle hardly shrinks, and both writing and a renderer's
    loading are several times faster.
    """
    import OpenEXR

    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {"RGB": np.ascontiguousarray(pixels[::-1], np.float16)}
    with OpenEXR.File(header, channels) as image:
        image.write(os.fspath(path))


def read_half_rgb(path: str | Path) -> np.ndarray:
    """Read an RGB image as ``(height, width, 3)`` float16, row 0 at the bottom.

    Raises
    ------
    TableError
        If the file is no readable EXR with RGB channels.
    """
    import OpenEXR

    try:
        with OpenEXR.File(os.fspath(path)) as image:
            pixels = image.channels()["RGB"].pixels
    except Exception as error:  # the library raises bare exceptions of several kinds
        raise TableError(f"{Path(path).name} cannot be read as an RGB EXR image; bake the scan again.") from error
    return np.ascontiguousarray(pixels[::-1], np.float16)
