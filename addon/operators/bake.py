# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the scene's scan into a spectral table."""

from __future__ import annotations

import bpy

from ...precompute.errors import Cancelled, DiffractionError
from ...precompute.parameters import BakeParameters
from .. import material, paths, properties, scan_store
from ..bake_job import BakeJob
from ..numbers import decimal


class DIFFRACTION_OT_bake(bpy.types.Operator):
    """Compute the spectral table of the scan: all colours for all directions of light and view"""

    bl_idname = "diffraction.bake"
    bl_label = "Bake"
    bl_options = {"UNDO"}

    sigma_s_um: properties.sigma_s()
    ensemble: properties.ensemble()
    series: properties.series()
    tolerance: properties.tolerance()
    level: properties.level()
    clip_percent: properties.clip_percent()
    illuminant: properties.illuminant()
    limit_mb: properties.limit_mb()

    _job = None
    _timer = None

    @classmethod
    def poll(cls, context):
        if not context.scene.diffraction.scan_path:
            cls.poll_message_set("Import a scan or use a preset first")
            return False
        if context.scene.diffraction.progress >= 0.0:
            cls.poll_message_set("A bake is running; Esc stops it")
            return False
        return True

    def execute(self, context):
        """Blocking, for scripts."""
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)
        try:
            job = self._make_job(context)
            job.watch = manager.progress_update
            return self._finish(context, job.run)
        except (DiffractionError, MemoryError) as error:
            return self._fail(context, error)
        finally:
            manager.progress_end()

    def invoke(self, context, event):
        """In a thread, with a progress bar in the panel."""
        for name in (
            "sigma_s_um",
            "ensemble",
            "series",
            "tolerance",
            "level",
            "clip_percent",
            "illuminant",
            "limit_mb",
        ):
            if not self.properties.is_property_set(name):
                setattr(self, name, getattr(context.scene.diffraction, name))
        try:
            self._job = self._make_job(context)
        except DiffractionError as error:
            return self._fail(context, error)
        self._job.start()
        self._timer = context.window_manager.event_timer_add(0.1, window=context.window)
        context.window_manager.modal_handler_add(self)
        context.scene.diffraction.progress = 0.0
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        if event.type == "ESC":
            self._job.cancel()
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        state = context.scene.diffraction
        if self._job.running:
            state.progress, state.progress_text = self._job.fraction, self._job.stage
            _redraw(context)
            return {"RUNNING_MODAL"}
        self._clear(context)
        return self._finish(context, self._job.result)

    def cancel(self, context):
        """Blender closes, or a file is loaded."""
        if self._job is not None:
            self._job.cancel()
        self._clear(context)

    def _make_job(self, context) -> BakeJob:
        parameters = BakeParameters(
            sigma_s_m=decimal(self.sigma_s_um) * 1e-6 or None,
            ensemble=self.ensemble,
            series=self.series,
            tolerance=decimal(self.tolerance),
            level=self.level,
            clip_percent=decimal(self.clip_percent) or None,
            illuminant=self.illuminant,
            limit_bytes=self.limit_mb * 1_000_000,
        )
        source, reading = scan_store.bake_source(context.scene)
        name = paths.absolute(context.scene.diffraction.scan_path).stem
        return BakeJob(source, paths.data_folder(), name, parameters, reading)

    def _finish(self, context, outcome):
        try:
            result = outcome()
        except Cancelled:
            self.report({"WARNING"}, "The bake was stopped; nothing was written")
            return {"CANCELLED"}
        except (DiffractionError, MemoryError) as error:
            return self._fail(context, error)
        state = context.scene.diffraction
        state.table_path = paths.relative(result.path)
        megabytes, seconds = result.table.layout.texel_bytes / 1e6, result.seconds["total"]
        state.table_info = f"{megabytes:.0f} MB, {result.table.info['terms']} terms, {seconds:.1f} s"
        material.refresh_table(result.path, context.scene)
        self.report({"INFO"}, f"Baked {result.path.name}: {state.table_info}")
        return {"FINISHED"}

    def _fail(self, context, error):
        text = str(error) or "There is not enough memory for this bake; bake a smaller scan or choose a smaller table."
        self.report({"ERROR"}, text)
        return {"CANCELLED"}

    def _clear(self, context):
        if self._timer is not None:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        context.scene.diffraction.progress = -1.0
        _redraw(context)


def _redraw(context) -> None:
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


CLASSES = (DIFFRACTION_OT_bake,)
