# SPDX-License-Identifier: GPL-3.0-or-later
"""What long operators share: a thread with progress and Esc from the panel, a blocking call from scripts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from ...precompute.errors import Cancelled, DiffractionError
from . import progress
from .job import Job
from .wording import in_window


def has_scan(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether the scene has a scan; says on the button why not."""
    if not context.scene.diffraction.scan_path:
        cls.poll_message_set("Import a scan or use a preset first")
        return False
    return True


if TYPE_CHECKING:
    _Operator = bpy.types.Operator
else:
    _Operator = object


#: Jobs of the operator at work in a window and its timer: what has to end with the extension, since Blender frees the
#: operator of a class that goes without a word to it.
_at_work: tuple[list[Job], bpy.types.Timer | None] = [], None


class Threaded(_Operator):
    """Mixin of operators whose work is a list of jobs.

    An operator gives `title`, `jobs` and `finished`; panels and status bar show the progress.
    """

    title = "Working"

    # Empty from the start: Blender cancels an operator also before it began, with its file browser.
    _jobs: list[Job] = []
    _results: list[Any] = []
    _timer = None

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """What is to be done, one after the other; may raise DiffractionError."""
        raise NotImplementedError

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """Write the results into the scene and return what to tell."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Blocking, for scripts."""
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        self._jobs, self._results = [], []
        try:
            self._jobs = self.jobs(context)
            for job in self._jobs:
                job.watch = manager.progress_update
                self._results.append(job.run())
            return self._tell(self.finished(context, self._results))
        except (DiffractionError, MemoryError) as error:
            return self._fail(error)
        finally:
            manager.progress_end()
            self._close()

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """In a thread, with progress in panel and status bar."""
        global _at_work
        try:
            self._jobs, self._results = self.jobs(context), []
        except (DiffractionError, MemoryError) as error:
            return self._fail(error)
        self._jobs[0].start()
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        _at_work = self._jobs, self._timer
        self._show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        job = self._jobs[len(self._results)]
        if event.type == "ESC" and event.value == "PRESS":
            job.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        if job.running:
            job.serve()
            self._show(context)
            return {"RUNNING_MODAL"}
        try:
            self._results.append(job.result())
            if len(self._results) < len(self._jobs):
                self._jobs[len(self._results)].start()
                return {"RUNNING_MODAL"}
            self._clear(context)
            return self._tell(self.finished(context, self._results))
        except Cancelled:
            self._clear(context)
            self.report({"WARNING"}, f"{self.title} was stopped; nothing was written")
            return {"CANCELLED"}
        except (DiffractionError, MemoryError) as error:
            self._clear(context)
            return self._fail(error)

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender closes, a file is loaded, or a file browser ends before anything began."""
        if not self._jobs:
            return
        for job in self._jobs:
            job.cancel()
        self._clear(context)

    def _tell(self, text: str) -> set[str]:
        if text:
            self.report({"INFO"}, text)
        return {"FINISHED"}

    def _fail(self, error: BaseException) -> set[str]:
        text = str(error) or "There is not enough memory for this; take a smaller scan or a smaller table."
        self.report({"ERROR"}, in_window(text))
        return {"CANCELLED"}

    def _show(self, context: bpy.types.Context) -> None:
        done, count = len(self._results), len(self._jobs)
        job = self._jobs[done]
        text = f"{self.title}: {job.stage}" + (f" ({done + 1} of {count})" if count > 1 else "")
        progress.show(text, (done + job.fraction) / count, getattr(type(self), "bl_idname", ""))
        if context.workspace is not None:
            context.workspace.status_text_set(_status)
        redraw_sidebars(context)

    def _close(self) -> None:
        for job in self._jobs:
            job.close()

    def _clear(self, context: bpy.types.Context) -> None:
        self._close()
        self._timer = None
        _leave(context)


def stop() -> None:
    """End what is at work in a window: the extension is being disabled."""
    jobs = _at_work[0]
    for job in jobs:
        job.cancel()
        job.close()
    if jobs:
        _leave(bpy.context)
    progress.clear()


def _leave(context: bpy.types.Context) -> None:
    """Nothing is at work any more."""
    global _at_work
    timer, _at_work = _at_work[1], ([], None)
    if timer is not None:
        context.window_manager.event_timer_remove(timer)
    progress.clear()
    if context.workspace is not None:
        context.workspace.status_text_set(None)
    redraw(context)


def _status(header: Any, context: bpy.types.Context) -> None:
    """The status bar while a job runs."""
    now = progress.running()
    header.layout.label(text="Stop", icon="EVENT_ESC")
    if now is not None:
        bar = header.layout.row()
        bar.ui_units_x = 14.0  # else the text is cut off
        bar.progress(factor=now.fraction, text=now.text)


def redraw_sidebars(context: bpy.types.Context) -> None:
    """Let the panels show how far a job is; the views beside them, which may be costly, stay as they are."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type == "VIEW_3D" else ():
                if region.type == "UI":
                    region.tag_redraw()


def redraw(context: bpy.types.Context) -> None:
    """Let all panels and image editors show what changed."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"VIEW_3D", "IMAGE_EDITOR", "PROPERTIES"}:
                area.tag_redraw()


def busy(cls: type[bpy.types.Operator]) -> bool:
    """Whether another job runs; says so on the button."""
    if progress.running() is not None:
        cls.poll_message_set("A bake or another computation is running; Esc stops it")
        return True
    return False
