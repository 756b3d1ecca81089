# SPDX-License-Identifier: GPL-3.0-or-later
"""Import a scan."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import FloatProperty, FloatVectorProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...precompute.errors import DiffractionError
from .. import scan_store
from ..numbers import decimal


class DIFFRACTION_OT_import_scan(bpy.types.Operator, ImportHelper):
    """Read the heights of a surface scan"""

    bl_idname = "diffraction.import_scan"
    bl_label = "Import Scan"
    bl_options = {"REGISTER", "UNDO"}

    filter_glob: StringProperty(default="*", options={"HIDDEN"})
    size_um: FloatVectorProperty(
        name="Size", description="Side lengths in micrometres; 0 takes them from the file (images have none)",
        size=2, default=(0.0, 0.0),
    )  # fmt: skip
    height_nm: FloatProperty(
        name="Height",
        description="Height range in nanometres; 0 takes it from the file (images have none)",
        default=0.0,
    )
    channel: StringProperty(name="Channel", description="Name or number of the channel; empty finds the heights")

    def execute(self, context):
        size_m = tuple(decimal(size) * 1e-6 for size in self.size_um) if any(self.size_um) else None
        height_m = decimal(self.height_nm) * 1e-9 if self.height_nm else None
        path = Path(bpy.path.abspath(self.filepath))
        try:
            field = scan_store.import_scan(context.scene, path, size_m, height_m, self.channel or None)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        channels = field.metadata.get("channels", [])
        others = f"; {len(channels) - 1} other channels" if len(channels) > 1 else ""
        self.report({"INFO"}, f"{path.name}: {context.scene.diffraction.scan_info}{others}")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_import_scan,)
