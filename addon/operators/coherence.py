# SPDX-License-Identifier: GPL-3.0-or-later
"""The coherence window of sunlight, on the scan that is there."""

from __future__ import annotations

import bpy

from ...precompute.bake.window import sunlight_sigma_s
from ...precompute.constants import COHERENCE_LENGTH_SUN_M
from ...precompute.errors import DiffractionError
from ...precompute.readers import read_scan
from ...precompute.scan.preparation import prepare
from ..numbers import decimal
from ..tables import bake_settings, scan_store


class DIFFRACTION_OT_coherence_of_sunlight(bpy.types.Operator):
    """Set the coherence window to that of sunlight, 16.25 um, or to the quarter of the scan's side that it allows"""

    bl_idname = "diffraction.coherence_of_sunlight"
    bl_label = "Coherence of Sunlight"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not context.scene.diffraction.scan_path:
            cls.poll_message_set("Import a scan or use a preset first")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        state = context.scene.diffraction
        try:
            source, reading = scan_store.bake_source(context.scene)
            patch = prepare(read_scan(source, **reading), bake_settings.parameters(state))
        except (DiffractionError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        sigma_s_m = sunlight_sigma_s(patch)
        state.sigma_s_um = sigma_s_m * 1e6
        said = f"{decimal(state.sigma_s_um):.4g} um"
        if sigma_s_m < COHERENCE_LENGTH_SUN_M / 4.0:
            self.report(
                {"WARNING"}, f"{said}, a quarter of the scan's side; sunlight's 16.25 um would be cut off by it"
            )
        else:
            self.report({"INFO"}, f"{said}, a quarter of sunlight's coherence length")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_coherence_of_sunlight,)
