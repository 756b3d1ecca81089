# SPDX-License-Identifier: GPL-3.0-or-later
"""Import a scan, choose another of its channels, or take up one that was stored before."""

from __future__ import annotations

import json
from pathlib import Path

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...precompute.errors import DiffractionError
from .. import scan_store
from ..numbers import decimal
from .threaded import busy

TURN_ITEMS = [
    ("0", "0\N{DEGREE SIGN}", "As it is"),
    ("1", "90\N{DEGREE SIGN}", "A quarter anticlockwise"),
    ("2", "180\N{DEGREE SIGN}", "Half a turn"),
    ("3", "270\N{DEGREE SIGN}", "A quarter clockwise"),
]

#: Blender keeps no reference to the strings of dynamic items.
_kept_items: list[tuple[str, str, str]] = []


class DIFFRACTION_OT_import_scan(bpy.types.Operator, ImportHelper):
    """Read the heights of a surface scan"""

    bl_idname = "diffraction.import_scan"
    bl_label = "Import Scan"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    filter_glob: StringProperty(default="*", options={"HIDDEN"})
    size_um: FloatVectorProperty(
        name="Size (um)", description="Side lengths in micrometres; 0 takes them from the file (images have none)",
        size=2, default=(0.0, 0.0),
    )  # fmt: skip
    height_nm: FloatProperty(
        name="Height (nm)",
        description="Height range in nanometres; 0 takes it from the file (images have none)",
        default=0.0,
    )
    channel: StringProperty(name="Channel", description="Name or number of the channel; empty finds the heights")
    flip_x: BoolProperty(name="Flip X", description="Exchange left and right")
    flip_y: BoolProperty(name="Flip Y", description="Exchange bottom and top")
    turn: EnumProperty(name="Turn", description="Turn anticlockwise, after flipping", items=TURN_ITEMS)

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def execute(self, context):
        size_m = tuple(decimal(size) * 1e-6 for size in self.size_um) if any(self.size_um) else None
        height_m = decimal(self.height_nm) * 1e-9 if self.height_nm else None
        placement = scan_store.Placement(self.flip_x, self.flip_y, int(self.turn))
        path = Path(bpy.path.abspath(self.filepath))
        return read_in(self, context, path, size_m, height_m, self.channel or None, placement)


class DIFFRACTION_OT_choose_channel(bpy.types.Operator):
    """Read another channel of the imported file"""

    bl_idname = "diffraction.choose_channel"
    bl_label = "Channel"
    bl_options = {"REGISTER", "UNDO"}

    def _items(self, context):
        names = json.loads(context.scene.diffraction.channels or "[]") if context is not None else []
        _kept_items[:] = [(str(index), name, "") for index, name in enumerate(names)]
        return _kept_items

    channel: EnumProperty(name="Channel", description="Channels of the imported file", items=_items)

    @classmethod
    def poll(cls, context):
        state = context.scene.diffraction
        if len(json.loads(state.channels or "[]")) < 2:
            cls.poll_message_set("The scan has no other channel")
            return False
        if not Path(json.loads(state.imported or "{}").get("path", "")).is_file():
            cls.poll_message_set("The file that the scan was imported from is gone")
            return False
        return not busy(cls)

    def execute(self, context):
        before = json.loads(context.scene.diffraction.imported)
        size_m = tuple(before["size_m"]) if "size_m" in before else None
        # A height range belongs to one channel only.
        return read_in(self, context, Path(before["path"]), size_m, None, self.channel, scan_store.Placement())


class DIFFRACTION_OT_use_stored_scan(bpy.types.Operator):
    """Go back to a scan that was stored with this file"""

    bl_idname = "diffraction.use_stored_scan"
    bl_label = "Stored Scan"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the stored scan, without .gsf")

    @classmethod
    def poll(cls, context):
        if not scan_store.stored_scans():
            cls.poll_message_set("No scan is stored with this file yet")
            return False
        return not busy(cls)

    def execute(self, context):
        found = [path for path in scan_store.stored_scans() if path.stem == self.name]
        if not found:
            self.report({"ERROR"}, f"There is no stored scan '{self.name}'; import it.")
            return {"CANCELLED"}
        try:
            scan_store.use_stored(context.scene, found[0])
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.scene.diffraction.table_name = ""
        self.report({"INFO"}, f"{self.name}: {context.scene.diffraction.scan_info}")
        return {"FINISHED"}


def read_in(operator, context, path, size_m, height_m, channel, placement):
    """Import and say what came in, or the reader's sentence."""
    manager = context.window_manager
    manager.progress_begin(0.0, 1.0)
    try:
        field = scan_store.import_scan(context.scene, path, size_m, height_m, channel, placement)
    except DiffractionError as error:
        operator.report({"ERROR"}, str(error))
        return {"CANCELLED"}
    finally:
        manager.progress_end()
    context.scene.diffraction.table_name = ""
    channels = field.metadata.get("channels", [])
    others = f"; {len(channels) - 1} other channels" if len(channels) > 1 else ""
    operator.report({"INFO"}, f"{path.name}: {context.scene.diffraction.scan_info}{others}")
    return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_import_scan, DIFFRACTION_OT_choose_channel, DIFFRACTION_OT_use_stored_scan)
