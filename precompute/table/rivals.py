# SPDX-License-Identifier: GPL-3.0-or-later
"""Two processes that bake one name: one of the two tables stands in the end, whole, and it is said which."""

from __future__ import annotations

from pathlib import Path

from ..errors import TableError
from ..files.stamp import file_stamp
from .table import SpectralTable, read_sidecar


class Rivals:
    """Watches a table's place from the beginning of its bake.

    Parameters
    ----------
    target
        Path of the EXR, which need not exist.
    """

    def __init__(self, target: Path) -> None:
        self._target = target
        self._before = file_stamp(target)

    def save(self, table: SpectralTable) -> tuple[Path, str]:
        """Write the table; its path, and a sentence without a full stop where another process was at the same name.

        Raises
        ------
        OutputError
            As `SpectralTable.save`.
        """
        replaced = file_stamp(self._target) != self._before
        path = table.save(self._target)
        if not _stands(path, table):
            return (
                path,
                f"Another process bakes {path.name} too and wrote it last: its table stands there",
            )
        if replaced:
            return path, f"Another process baked {path.name} meanwhile; this table took its place"
        return path, ""


def _stands(path: Path, table: SpectralTable) -> bool:
    try:
        return read_sidecar(path).get("key") == table.info.get("key")
    except TableError:  # it is being replaced
        return False
