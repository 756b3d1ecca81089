# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake as a job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ...precompute.bake.baking import BakeReport, bake_file
from ...precompute.parameters import BakeParameters
from ...precompute.table.cache import TableCache
from ...precompute.table.importance import ensure_importance
from ..jobs.job import Job, Progress
from .gpu.device import use_gpu
from .gpu.transforms import GpuTransforms


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
    device
        Of `gpu_bake.device.ITEMS`.

    Raises
    ------
    ParameterError
        If the device is not to be had.
    """

    def __init__(
        self,
        source: Path,
        out_dir: Path,
        name: str,
        parameters: BakeParameters,
        reading: dict[str, Any],
        cache: TableCache | None = None,
        device: str = "CPU",
    ) -> None:

        def work(progress: Progress) -> BakeReport:
            report = bake_file(
                source,
                out_dir,
                parameters,
                progress=progress,
                name=name,
                cache=cache,
                transforms=self._transforms,
                **reading,
            )
            progress("directions", 1.0)
            ensure_importance(report.path, report.table)  # here and not in Apply, for which the window would wait
            return report

        super().__init__(work)
        self._transforms = GpuTransforms(self.on_main, race=device == "AUTO") if use_gpu(device) else None

    @property
    def device(self) -> str:
        """What computed the transforms, and why not another; for the user."""
        return self._transforms.device if self._transforms is not None else "processor"

    def close(self) -> None:
        """Free the GPU's memory."""
        if self._transforms is not None:
            self._transforms.close()
