# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages of TIFF files, looked at before they are decoded: damaged counts would allocate gigabytes."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from .limits import LIMIT_PIXELS, check_density, check_loaded, check_shape, cropping

#: None, deflate (two numbers) and PackBits: what tifffile decodes without further libraries.
PLAIN_COMPRESSIONS = (1, 8, 32946, 32773)
_MOST_CHANNELS = 4


@contextmanager
def open_tiff(path: Path) -> Iterator[Any]:
    """An open ``tifffile.TiffFile`` that keeps its remarks on damaged tags to itself."""
    import tifffile

    logger = logging.getLogger("tifffile")
    before = logger.disabled
    logger.disabled = True
    try:
        with tifffile.TiffFile(path) as file:
            yield file
    finally:
        logger.disabled = before


def decoded(page: Any, path: Path) -> np.ndarray:
    """The values of a page.

    Raises
    ------
    ScanError
        If the page declares more than there can be.
    """
    check_shape(page.imagelength, page.imagewidth)
    if cropping() and page.is_memmappable:
        return np.memmap(path, page.dtype.newbyteorder(page.parent.byteorder), "r", page.dataoffsets[0], page.shape)
    check_loaded(page.imagelength, page.imagewidth)
    chunk = math.prod(page.chunks) if page.chunks else 0
    if page.size > _MOST_CHANNELS * LIMIT_PIXELS or chunk > _MOST_CHANNELS * LIMIT_PIXELS or page.imagedepth != 1:
        raise ScanError(f"The TIFF declares an image of the shape {page.shape}; save it as one grey picture.")
    if sum(page.databytecounts) > path.stat().st_size:
        raise ScanError("The TIFF declares more data than the file holds; copy or export it again.")
    check_density(path, page.size * max(page.bitspersample, 1))
    return page.asarray()
