# SPDX-License-Identifier: GPL-3.0-or-later
"""How large a scan may be: checked against what a file *declares*, before anything is allocated."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from ...errors import ScanError, SizeLimitError

#: Most pixels of one channel (5792 x 5792); a reader then stays below 1 GB.
LIMIT_PIXELS = 32 * 1024 * 1024

#: Largest file that is opened at all.
LIMIT_FILE_BYTES = 512 * 1024 * 1024

#: The same where only a part of the scan is wanted, whose rows alone are taken from the file.
LIMIT_PIXELS_CROPPED, LIMIT_FILE_BYTES_CROPPED = 1 << 32, 64 << 30

_CROPPING: ContextVar[bool] = ContextVar("cropping", default=False)

#: The same for numbers written as text, which take several times their size while they are parsed.
LIMIT_TEXT_BYTES = 160 * 1024 * 1024


#: Most bytes of pixels that a byte of file can stand for: the bound of deflate is 1032.
_DENSEST = 1040


@contextmanager
def while_cropping(wanted: bool) -> Iterator[None]:
    """Within this block a larger scan may be declared, since most of it is never loaded."""
    token = _CROPPING.set(wanted)
    try:
        yield
    finally:
        _CROPPING.reset(token)


def cropping() -> bool:
    """Whether a part of a scan is read: arrays are then mapped, not loaded."""
    return _CROPPING.get()


def check_density(path: Path, bits: int) -> None:
    """Refuse a compressed picture that declares more than its file can hold: a bomb, or a damaged header.

    Parameters
    ----------
    path
        The file.
    bits
        Of all declared pixels.

    Raises
    ------
    ScanError
        If no compression brings them into the file.
    """
    if bits // 8 > _DENSEST * path.stat().st_size:
        raise ScanError("The picture declares more pixels than its file can hold; copy or export it again.")


def check_text(path: Path) -> None:
    """Refuse a text file that is too large.

    Raises
    ------
    SizeLimitError
        If it has more than ``LIMIT_TEXT_BYTES``.
    """
    if path.stat().st_size > LIMIT_TEXT_BYTES:
        raise SizeLimitError(
            f"The text file has {path.stat().st_size >> 20} MB, above the limit of {LIMIT_TEXT_BYTES >> 20} MB; "
            "export it as .gsf."
        )


def check_shape(rows: int, cols: int) -> None:
    """Refuse a declared shape that is no scan or that is too large.

    Raises
    ------
    ScanError
        If a count is below 2.
    SizeLimitError
        If there are more than ``LIMIT_PIXELS`` pixels.
    """
    if rows < 2 or cols < 2:
        raise ScanError(f"The scan has {rows} x {cols} pixels; a heightfield needs at least 2 x 2.")
    if rows * cols > (LIMIT_PIXELS_CROPPED if cropping() else LIMIT_PIXELS):
        raise SizeLimitError(
            f"The file declares {rows} x {cols} pixels, above the limit of {LIMIT_PIXELS}; read a part of it with "
            "--crop-um LEFT RIGHT BOTTOM TOP."
        )


def check_loaded(rows: int, cols: int) -> None:
    """Refuse a shape that must be loaded whole, whatever part is wanted: compressed data, text.

    Raises
    ------
    SizeLimitError
        If there are more than ``LIMIT_PIXELS`` pixels.
    """
    if rows * cols > LIMIT_PIXELS:
        raise SizeLimitError(
            f"The file declares {rows} x {cols} pixels, above the limit of {LIMIT_PIXELS}, and its kind can only be "
            "read whole; export a part of it, or all as .gsf, of which --crop-um reads a part."
        )
