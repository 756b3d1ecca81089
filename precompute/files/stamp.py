# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a file is still the one that was looked at, without reading it."""

from __future__ import annotations

import os
from pathlib import Path

#: Time (ns), bytes and number of the file in its file system.
Stamp = tuple[int, int, int]


def file_stamp(path: str | Path) -> Stamp | None:
    """What changes when a file is written anew; None where there is none, or can be none of that name."""
    try:
        status = os.stat(path)
    except (OSError, ValueError):
        return None
    return status.st_mtime_ns, status.st_size, status.st_ino
