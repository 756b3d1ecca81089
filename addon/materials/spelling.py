# SPDX-License-Identifier: GPL-3.0-or-later
"""Names by which Cycles reads a file anew.

Cycles keeps images by their names as long as its session lives: with *Persistent Data* from render to render, in a
viewport as long as it is rendered. A file that was written anew needs another name, and the same file has many:
``folder/t.exr``, ``folder/./t.exr``, ``folder/.//./t.exr``.
"""

from __future__ import annotations

import os
from pathlib import Path

from ...precompute.files.stamp import Stamp, file_stamp

#: Each file at the last look, and how often it was another one.
_versions: dict[Path, tuple[Stamp | None, int]] = {}


def fresh(name: str, path: Path) -> str:
    """A file's name as one that no renderer of this session has read another content by.

    Parameters
    ----------
    name
        As it is to be read, also relative to the .blend (``//``).
    path
        The same, absolute.
    """
    now = file_stamp(path)
    before, version = _versions.get(path, (now, 0))
    if now is not None and before is not None and now != before:
        version += 1
    _versions[path] = (now if now is not None else before, version)
    return spell(name, version)


def spell(name: str, version: int) -> str:
    """The name of a file in another spelling for each version; the plain one for version 0."""
    head, slash, last = name.replace(os.sep, "/").rpartition("/")
    if version == 0 or not slash:
        return name
    return f"{head}{slash}{''.join('.' + '/' * (1 + int(digit)) for digit in f'{version:b}')}{last}"
