# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake the scene's scan into a spectral table."""

from __future__ import annotations

from typing import Any, cast

import bpy
from bpy.props import EnumProperty, StringProperty

from ...precompute.errors import DiffractionError
from .. import paths, properties
from ..given import is_given
from ..jobs.job import Job
from ..jobs.threaded import Threaded, busy, has_scan
from ..materials import refresh
from ..preferences import bake_device, table_cache
from ..tables import bake_settings, estimates, light_file, recipe, scan_store
from ..tables.bake_job import BakeJob
from ..tables.gpu.device import ITEMS
from ..tables.table_state import texture_bytes


class DIFFRACTION_OT_bake(Threaded, bpy.types.Operator):
    """Compute the spectral table of the scan: all colours for all directions of light and view"""

    bl_idname = "diffraction.bake"
    bl_label = "Bake"
    bl_options = {"UNDO", "PRESET"}
    title = "Baking"

    sigma_s_um: properties.sigma_s()
    ensemble: properties.ensemble()
    replicas: properties.replicas()
    series: properties.series()
    tolerance: properties.tolerance()
    level: properties.level()
    use_crop: properties.use_crop()
    crop_um: properties.crop_um()
    align_rows: properties.align_rows()
    clip_percent: properties.clip_percent()
    smooth_nm: properties.smooth_nm()
    tile: properties.tile()
    detail: properties.detail()
    error_percent: properties.error_percent()
    illuminant: properties.illuminant()
    illuminant_file: properties.illuminant_file()
    illuminant_data: properties.illuminant_data()
    limit_mb: properties.limit_mb()
    substrate: properties.substrate()
    films: properties.films()
    lacquer: properties.lacquer()
    energy: properties.energy()
    scale_headroom: properties.headroom("Scale")
    depth_headroom: properties.headroom("Depth")
    device: EnumProperty(
        name="Device",
        description="What computes the transforms; the preferences decide where it is left out",
        items=ITEMS,
        options={"SKIP_SAVE"},
    )
    name: StringProperty(name="Name", description="Name of the table; empty takes the scan's", options={"SKIP_SAVE"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_scan(cls, context) and not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """One bake. What the caller left out is taken from the panel, what is used is shown there."""
        state = context.scene.diffraction
        given = is_given(self, "illuminant_file")
        bake_settings.copy(state, self, only_unset=True)
        if given:
            self.illuminant_data = ""  # a file that the caller names must be there
        chosen = bake_settings.parameters(self)
        self.illuminant_data = light_file.values(self)
        scan_store.bring_here(context.scene)
        source, reading = scan_store.bake_source(context.scene)
        name = self.name or state.table_name or paths.absolute(state.scan_path).stem
        device = self.device if is_given(self, "device") else bake_device()
        return [BakeJob(source, paths.readable(paths.data_folder()), name, chosen, reading, table_cache(), device)]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The table becomes the scene's, and materials that use it are brought up to it."""
        (result,) = results
        state = context.scene.diffraction
        bake_settings.copy(self, state)
        state.table_path = paths.relative(result.path)
        state.table_recipe = recipe.make(state)
        if result.cache != "hit":  # a table from the cache says nothing of the machine's speed
            estimates.learn(context.scene, result.seconds["total"])
        try:
            refresh.refresh(result.path, state.table_recipe)
        except DiffractionError as error:
            self.report({"WARNING"}, str(error))
        if result.rival:
            self.report({"WARNING"}, f"{result.rival}.")
        megabytes = texture_bytes(result.table.layout.texel_bytes) / 1e6
        terms, seconds = result.table.info["terms"], result.seconds["total"]
        by = "" if result.cache == "hit" else f" ({cast(BakeJob, self._jobs[0]).device})"
        return f"Baked {result.path.name}: {megabytes:.0f} MB of texture, {terms} terms, {seconds:.1f} s{by}"


CLASSES = (DIFFRACTION_OT_bake,)
