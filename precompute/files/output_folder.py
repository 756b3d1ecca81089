# SPDX-License-Identifier: GPL-3.0-or-later
"""Folders that results are written to."""

from __future__ import annotations

from pathlib import Path

from ..errors import OutputError


def ensure_folder(path: str | Path) -> Path:
    """Make a folder (and its parents) unless it exists.

    Raises
    ------
    OutputError
        If it cannot be made, or a file is in its place.
    """
    path = Path(path)
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"The folder {path} cannot be made ({error.strerror}); choose another folder.") from error
    return path
