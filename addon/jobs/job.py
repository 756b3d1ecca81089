# SPDX-License-Identifier: GPL-3.0-or-later
"""Work of the core as a blocking call for scripts, or in a thread behind a progress bar."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from typing import Any

from ...precompute.errors import Cancelled

#: What a job is given to report with: a stage's name and the fraction done; raises Cancelled when the user stops.
Progress = Callable[[str, float], None]


class _Request:
    """A function that a thread waits for."""

    def __init__(self, function: Callable[[], Any]) -> None:
        self.done = threading.Event()
        self.result: Any = None
        self.error: BaseException | None = None
        self._function = function

    def answer(self) -> None:
        try:
            self.result = self._function()
        except BaseException as error:  # raised where the function is waited for
            self.error = error
        self.done.set()


class Job:
    """Work that can be watched and stopped. The core never touches Blender, so a thread is safe.

    Parameters
    ----------
    work
        Called with a `Progress`; what it returns is the job's result.
    """

    def __init__(self, work: Callable[[Progress], Any]) -> None:
        self.stage, self.fraction = "start", 0.0
        self.watch: Callable[[float], object] | None = None  # called with the fraction, in the thread that works
        self.error: BaseException | None = None
        self._result: Any = None
        self._work = work
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self._requests: queue.SimpleQueue[_Request] = queue.SimpleQueue()

    def run(self) -> Any:
        """Work and return the result, or raise what the core raises (`Cancelled` after `cancel`)."""
        self._result = self._work(self._progress)
        return self._result

    def start(self) -> None:
        """Work in a thread; watch `running`, then call `result`."""
        self._thread = threading.Thread(target=self._guarded, name="diffraction", daemon=True)
        self._thread.start()

    @property
    def running(self) -> bool:
        """Whether the thread is at work."""
        return self._thread is not None and self._thread.is_alive()

    def cancel(self) -> None:
        """Ask the work to stop at its next step; nothing half-written stays."""
        self.stage = "stopping"
        self._stop.set()

    def on_main(self, function: Callable[[], Any]) -> Any:
        """Call a function in Blender's main thread, which has to `serve`, and return its result.

        Raises
        ------
        Cancelled
            If the job is stopped before the function was called.
        """
        if threading.current_thread() is threading.main_thread():
            return function()
        request = _Request(function)
        self._requests.put(request)
        while not request.done.wait(0.1):
            if self._stop.is_set():
                raise Cancelled
        if request.error is not None:
            raise request.error
        return request.result

    def serve(self, seconds: float = 0.05) -> None:
        """Do what the thread asked to be done in this one, for about so long: one request may bring the next."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0.0:
            try:
                request = self._requests.get(timeout=min(left, 0.005))
            except queue.Empty:
                return
            request.answer()

    def close(self) -> None:
        """Let go of what belongs to the main thread; called there when the job has ended or is given up."""

    def result(self) -> Any:
        """The result of a finished thread, or its error raised here."""
        if self._thread is not None:
            self._thread.join()
        if self.error is not None:
            raise self.error
        return self._result

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
