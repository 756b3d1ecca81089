# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake as a job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..precompute.bake import bake_file
from ..precompute.cache import TableCache
from ..precompute.parameters import BakeParameters
from .job import Job


class BakeJob(Job):
    """Bakes a scan's file.

    Parameters
    ----------
    source, out_dir, name
        The scan, the folder of the table and its name.
    parameters
        What decides the table.
    reading
        How to read the scan, see `precompute.readers.read_scan`.
    cache
        Where tables are kept, or None.
    """

    def __init__(
        self,
        source: Path,
        out_dir: Path,
        name: str,
        parameters: BakeParameters,
        reading: dict[str, Any],
        cache: TableCache | None = None,
    ) -> None:
        super().__init__(
            lambda progress: bake_file(
                source, out_dir, parameters, progress=progress, name=name, cache=cache, **reading
            )
        )
