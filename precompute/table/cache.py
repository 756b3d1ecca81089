# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that were baked before: a folder of atlases named by what decides them.

The key is the hash of the heights (not of the path), the parameters and the versions of format and
computation, so an entry never goes stale. An entry is one file that appears whole or not at all and
carries its own hash: several processes may bake into one cache without a lock, and whoever comes
second writes the same bytes again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import struct
from pathlib import Path
from typing import Any

import numpy as np

from ..constants import BAKE_VERSION, CACHE_LIMIT_BYTES, TABLE_FORMAT_VERSION
from ..errors import OutputError, ParameterError, TableError
from ..files.atomic import remove_stale
from ..files.output_folder import ensure_folder
from ..parameters import BakeParameters
from ..scan.heightfield import HeightField
from .table import SpectralTable


def table_key(scan: HeightField, parameters: BakeParameters) -> str:
    """The name of all that decides a table, as 64 hexadecimal digits.

    Parameters
    ----------
    scan
        As read: heights, mask, pixel size and processing count; name, path and file format do not.
    parameters
        What decides the bake.
    """
    decides = {
        "format": TABLE_FORMAT_VERSION,
        "computation": BAKE_VERSION,
        "parameters": parameters.to_dict(),
        "processing": list(scan.processing),
        "shape": list(scan.shape),
    }
    digest = hashlib.sha256(json.dumps(decides, sort_keys=True, default=str).encode())
    digest.update(struct.pack("<dd", scan.dx, scan.dy))
    # A missing point may hold any NaN; -0.0 and 0.0 are one height.
    digest.update(np.ascontiguousarray(np.where(scan.missing, 0.0, scan.heights) + 0.0, "<f8").data)
    digest.update(np.packbits(scan.missing).data)
    return digest.hexdigest()


def origin(scan: HeightField) -> dict[str, Any]:
    """What a table says of its scan without deciding any texel."""
    return {key: scan.metadata.get(key) for key in ("name", "format", "channel", "sha256")}


class TableCache:
    """A folder of tables by key, the ones used last kept within a limit.

    Parameters
    ----------
    folder
        Made if missing.
    limit_bytes
        Largest sum of the entries' sizes on disk.

    Raises
    ------
    OutputError
        If the folder cannot be made.
    ParameterError
        If the limit is not positive.
    """

    def __init__(self, folder: str | os.PathLike[str], limit_bytes: int = CACHE_LIMIT_BYTES) -> None:
        if limit_bytes <= 0:
            raise ParameterError("The size limit of the cache must be positive; use no cache instead.")
        self.folder = ensure_folder(Path(folder))
        self.limit_bytes = limit_bytes

    def get(self, key: str) -> SpectralTable | None:
        """The table of a key, or None. A damaged entry is removed."""
        path = self._path(key)
        if not path.is_file():
            return None
        try:
            table = SpectralTable.load_atlas(path)
            if table.info.get("key") != key:
                raise TableError(f"{path.name} holds another table.")
        except TableError:
            _remove(path)
            return None
        # Used now: the clean-up takes the oldest first. Another process may have removed it meanwhile.
        with contextlib.suppress(OSError):
            os.utime(path)
        return table

    def put(self, key: str, table: SpectralTable) -> bool:
        """Store a table and make room for it; False where it could not be stored.

        A cache that is full, read-only or gone never spoils the bake that it was to speed up.
        """
        if table.atlas.nbytes > self.limit_bytes:
            return False
        try:
            table.save_atlas(self._path(key))
        except OutputError:
            return False
        self.clean()
        return True

    def size_bytes(self) -> int:
        """Bytes of all entries."""
        return sum(size for _, size, _ in self._entries())

    def clean(self) -> None:
        """Remove what was used longest ago until the rest is within the limit, and what killed processes left."""
        entries = sorted(self._entries())
        total = sum(size for _, size, _ in entries)
        for _, size, path in entries:
            if total <= self.limit_bytes:
                break
            _remove(path)
            total -= size
        remove_stale(self.folder)

    def clear(self) -> None:
        """Remove all entries."""
        for _, _, path in self._entries():
            _remove(path)

    def _path(self, key: str) -> Path:
        if len(key) != 64 or not set(key) <= set("0123456789abcdef"):
            raise ValueError(f"{key!r} is no key")
        return self.folder / f"{key}.exr"

    def _entries(self) -> list[tuple[int, int, Path]]:
        """Time of the last use, size and path of each entry; nothing else in the folder is ours."""
        entries = []
        for path in self.folder.glob("*.exr"):
            if len(path.stem) != 64:
                continue
            try:
                status = path.stat()
            except OSError:  # removed meanwhile
                continue
            entries.append((status.st_mtime_ns, status.st_size, path))
        return entries


def _remove(path: Path) -> None:
    """Another process may have removed it, or still have it open (Windows): then it stays until the next time."""
    with contextlib.suppress(OSError):
        path.unlink()
