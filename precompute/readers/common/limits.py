# SPDX-License-Identifier: GPL-3.0-or-later
"""How large a scan may be: checked against what a file *declares*, before anything is allocated."""

from __future__ import annotations

from pathlib import Path

from ...errors import ScanError, SizeLimitError

#: Most pixels of one channel (5792 x 5792); a reader then stays below 1 GB.
LIMIT_PIXELS = 32 * 1024 * 1024

#: Largest file that is opened at all.
LIMIT_FILE_BYTES = 512 * 1024 * 1024

#: The same for numbers written as text, which take several times their size while they are parsed.
LIMIT_TEXT_BYTES = 160 * 1024 * 1024


#: Most bytes of pixels that a byte of file can stand for: the bound of deflate is 1032.
_DENSEST = 1040


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
    if rows * cols > LIMIT_PIXELS:
        raise SizeLimitError(
            f"The file declares {rows} x {cols} pixels, above the limit of {LIMIT_PIXELS}; crop the scan first."
        )
