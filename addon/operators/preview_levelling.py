# SPDX-License-Identifier: GPL-3.0-or-later
"""See what levelling does before a bake."""

from __future__ import annotations

from typing import Any

import bpy

from .. import pictures, properties
from ..given import take
from ..jobs.job import Job, Progress
from ..jobs.threaded import Threaded, busy, has_scan
from ..tables import bake_settings, scan_store

#: Name of the image.
IMAGE = "Diffraction Levelling"


class DIFFRACTION_OT_preview_levelling(Threaded, bpy.types.Operator):
    """Show the heights before and after, their histogram, and the spectrum with the lattice it holds"""

    bl_idname = "diffraction.preview_levelling"
    bl_label = "Preview"
    bl_options = {"UNDO"}
    title = "Levelling"

    level: properties.level()
    use_crop: properties.use_crop()
    crop_um: properties.crop_um()
    align_rows: properties.align_rows()
    clip_percent: properties.clip_percent()
    smooth_nm: properties.smooth_nm()
    tile: properties.tile()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_scan(cls, context) and not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Read, prepare and draw, away from Blender."""
        from dataclasses import replace

        take(self, context.scene.diffraction, bake_settings.LEVELLING)
        source, reading = scan_store.bake_source(context.scene)
        chosen = replace(bake_settings.parameters(context.scene.diffraction), **bake_settings.levelling(self))
        folder = pictures.scratch_folder()

        def work(progress: Progress) -> Any:
            from ...precompute.readers import read_scan
            from ...precompute.scan.levelling_picture import levelling_picture, levelling_thumbnail
            from ...precompute.scan.preparation import prepare

            progress("read", 0.0)
            before = read_scan(source, **reading)
            progress("level", 0.2)
            after = prepare(before, chosen)
            progress("draw", 0.5)
            large, small = levelling_picture(before, after), levelling_thumbnail(before, after)
            progress("done", 1.0)
            picture = pictures.written(folder, large, small=small)
            return picture, [step["warning"] for step in after.processing if step.get("warning")]

        return [Job(work)]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The picture becomes an image."""
        ((picture, warnings),) = results
        pictures.show_file(context, IMAGE, picture)
        for warning in warnings:
            self.report({"WARNING"}, warning)
        return f"The image '{IMAGE}' shows the heights; open it in an image editor"


CLASSES = (DIFFRACTION_OT_preview_levelling,)
