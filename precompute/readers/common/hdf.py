# SPDX-License-Identifier: GPL-3.0-or-later
"""HDF5 files by h5py, which is not bundled: where it is not installed the file is refused with its name."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import ScanError
from .limits import LIMIT_PIXELS, check_density

MAGIC = b"\x89HDF\r\n\x1a\n"
_MOST_ITEMS = 10_000


@contextmanager
def open_hdf(path: Path) -> Iterator[Any]:
    """An open ``h5py.File``.

    Raises
    ------
    ImportError
        If h5py is not installed.
    ScanError
        If the library cannot make sense of the file.
    """
    import h5py

    try:
        with h5py.File(path, "r") as file:
            yield file
    except (OSError, RuntimeError, KeyError, ValueError, TypeError, AttributeError, UnicodeDecodeError) as error:
        text = " ".join(str(error).split())[:100].rstrip(" .")
        raise ScanError(f"The HDF5 file is damaged or of an unknown variant ({text}); export it again.") from error


def groups(file: Any) -> Iterator[Any]:
    """All groups of a file, the root first, without links out of it."""
    import h5py

    waiting, seen = [file["/"]], 0
    while waiting:
        group = waiting.pop(0)
        yield group
        for name in list(group):
            seen += 1
            if seen > _MOST_ITEMS:
                return
            if (
                group.get(name, getclass=True, getlink=True) is h5py.HardLink
                and group.get(name, getclass=True) is h5py.Group
            ):
                waiting.append(group[name])


def word(value: Any) -> str:
    """A string attribute, however it was stored."""
    if isinstance(value, np.ndarray):
        value = value.ravel()[0] if value.size else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def number_of(attributes: Any, *keys: str) -> float | None:
    """The first of these attributes that is there and is a finite number."""
    for key in keys:
        if key in attributes:
            try:
                value = float(np.ravel(attributes[key])[0])
            except (TypeError, ValueError, IndexError):
                continue
            if np.isfinite(value):
                return value
    return None


def values_of(path: Path, data: Any) -> np.ndarray:
    """All values of a dataset.

    Raises
    ------
    ScanError
        If it is no array of numbers, or declares more than there can be.
    """
    if data.dtype.kind not in "iuf" or data.size > 4 * LIMIT_PIXELS:
        raise ScanError(f"The HDF5 file holds {data.dtype} of the shape {data.shape}, which is no map; export the map.")
    check_density(path, 8 * data.size * data.dtype.itemsize)
    return data[()]
