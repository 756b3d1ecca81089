# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake, as a blocking call for scripts or in a thread behind a progress bar."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..precompute.bake import BakeReport, bake_file
from ..precompute.errors import Cancelled
from ..precompute.parameters import BakeParameters


class BakeJob:
    """A bake that can be watched and stopped. The core never touches Blender, so a thread is safe.

    Parameters
    ----------
    source, out_dir, name
        The scan, the folder of the table and its name.
    parameters
        What decides the table.
    reading
        How to read the scan, see `precompute.readers.read_scan`.
    """

    def __init__(
        self, source: Path, out_dir: Path, name: str, parameters: BakeParameters, reading: dict[str, Any]
    ) -> None:
        self.stage, self.fraction = "start", 0.0
        self.watch: Callable[[float], object] | None = None  # called with the fraction, in the thread that bakes
        self.report: BakeReport | None = None
        self.error: BaseException | None = None
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._arguments = (source, out_dir, parameters), {"name": name, **reading}

    def run(self) -> BakeReport:
        """Bake and return the report, or raise what the core raises (`Cancelled` after `cancel`)."""
        arguments, options = self._arguments
        self.report = bake_file(*arguments, progress=self._progress, **options)
        return self.report

    def start(self) -> None:
        """Bake in a thread; watch `running`, then call `result`."""
        self._thread = threading.Thread(target=self._guarded, name="diffraction bake", daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the thread is at work."""
        return self._thread is not None and self._thread.is_alive()

    def cancel(self) -> None:
        """Ask the bake to stop at its next step; nothing half-written stays."""
        self._stop.set()

    def result(self) -> BakeReport:
        """The report of a finished thread, or its error raised here."""
        if self._thread is not None:
            self._thread.join()
        if self.error is not None:
            raise self.error
        assert self.report is not None
        return self.report

    def _guarded(self) -> None:
        try:
            self.run()
        except BaseException as error:  # handed over to the thread that asks for the result
            self.error = error

    def _progress(self, stage: str, fraction: float) -> None:
        self.stage, self.fraction = stage, fraction
        if self.watch is not None:
            self.watch(fraction)
        if self._stop.is_set():
            raise Cancelled
