# SPDX-License-Identifier: GPL-3.0-or-later
"""Half-float RGB images in OpenEXR files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import TableError

#: Header attribute that carries a text of ours.
_TEXT = "diffractionShader"


def write_half_rgb(path: str | Path, pixels: np.ndarray, text: str = "") -> None:
    """Write ``(height, width, 3)`` float16 pixels; row 0 of the array is the *bottom* of the picture.

    ``text`` goes into the header, so that pixels and description appear in one file at one moment.

    Uncompressed: half-float speckle hardly shrinks, and both writing and a renderer's
    loading are several times faster.
    """
    import OpenEXR

    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage, _TEXT: text}
    write_image(path, header, {"RGB": np.ascontiguousarray(pixels[::-1], np.float16)})


def write_image(path: str | Path, header: dict[str, Any], channels: dict[str, np.ndarray]) -> None:
    """Write one part of an EXR; a full disk is an OSError as everywhere else.

    The library raises bare RuntimeErrors, ``Failed to write pixel data to image file "...". File too large.``

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    import OpenEXR

    try:
        with OpenEXR.File(header, channels) as image:
            image.write(os.fspath(path))
    except RuntimeError as error:
        raise OSError(str(error).rpartition('". ')[2].strip() or "the image cannot be written") from error


#: Most bytes of pixels for one byte of file: what a header declares is checked before it is allocated.
_MOST_COMPRESSION = 100


def read_half_rgb(path: str | Path, width: int, height: int) -> np.ndarray:
    """Read an RGB image of known size as ``(height, width, 3)`` float16, row 0 at the bottom.

    Raises
    ------
    TableError
        If the file is no readable EXR with RGB channels, or of another size.
    """
    import OpenEXR

    name = Path(path).name
    try:
        with OpenEXR.File(os.fspath(path), header_only=True) as image:
            low, high = (np.array(corner, np.int64) for corner in image.header()["dataWindow"])
        if (high - low + 1).tolist() != [width, height]:
            raise TableError(f"{name} has not the size that its sidecar names; bake the scan again.")
        if 6 * width * height > _MOST_COMPRESSION * os.path.getsize(path):
            raise TableError(f"{name} is damaged, it declares more pixels than it can hold; bake the scan again.")
        with OpenEXR.File(os.fspath(path)) as image:
            pixels = image.channels()["RGB"].pixels
    except TableError:
        raise
    except Exception as error:  # the library raises bare exceptions of several kinds
        raise TableError(f"{name} cannot be read as an RGB EXR image; bake the scan again.") from error
    if pixels.shape != (height, width, 3):
        raise TableError(f"{name} is no RGB EXR image; bake the scan again.")
    with np.errstate(over="ignore"):  # a damaged atlas of 32-bit floats; its hash will not match
        return np.ascontiguousarray(pixels[::-1], np.float16)


def read_text(path: str | Path) -> str:
    """The text that :func:`write_half_rgb` put into the header; empty where there is none.

    Raises
    ------
    TableError
        If the file is no readable EXR.
    """
    import OpenEXR

    try:
        with OpenEXR.File(os.fspath(path), header_only=True) as image:
            text = image.header().get(_TEXT, "")
    except Exception as error:  # the library raises bare exceptions of several kinds
        raise TableError(f"{Path(path).name} cannot be read as an EXR image; bake the scan again.") from error
    return text if isinstance(text, str) else ""
