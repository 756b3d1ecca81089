# SPDX-License-Identifier: GPL-3.0-or-later
"""Import a scan, choose another of its channels, or take up one that was stored before."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty
from bpy_extras.io_utils import ImportHelper

from ...precompute.errors import ScanError
from .. import paths
from ..given import is_given
from ..jobs.job import Job, Progress
from ..jobs.threaded import Threaded, busy
from ..numbers import decimal
from ..preferences import last_folder, remember_folder
from ..tables import scan_store

TURN_ITEMS = [
    ("0", "0\N{DEGREE SIGN}", "As it is"),
    ("1", "90\N{DEGREE SIGN}", "A quarter anticlockwise"),
    ("2", "180\N{DEGREE SIGN}", "Half a turn"),
    ("3", "270\N{DEGREE SIGN}", "A quarter clockwise"),
]

#: Blender keeps no reference to the strings of dynamic items.
_kept_items: list[tuple[str, str, str]] = []


class _Takes(Threaded):
    """Reads a scan away from Blender, and makes it the scene's."""

    title = "Reading"

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The scene shows the scan."""
        (scan,) = results
        scan_store.adopt(context.scene, scan)
        name = Path(scan.imported["path"]).name if scan.imported else scan.path.stem
        others = f"; {len(scan.channels) - 1} other channels" if len(scan.channels) > 1 else ""
        return f"{name}: {scan.info}{others}"


class DIFFRACTION_OT_import_scan(_Takes, bpy.types.Operator, ImportHelper):
    """Read the heights of a surface scan"""

    bl_idname = "diffraction.import_scan"
    bl_label = "Import Scan"
    bl_options = {"REGISTER", "UNDO", "PRESET"}

    # What belongs to one file is not remembered for the next: SKIP_SAVE, all of them.
    filepath: StringProperty(
        name="File Path", description="The scan", subtype="FILE_PATH", maxlen=1024, options={"SKIP_SAVE"}
    )
    filter_glob: StringProperty(default="*", options={"HIDDEN", "SKIP_SAVE"})
    size_um: FloatVectorProperty(
        name="Size (um)", description="Side lengths in micrometres; 0 takes them from the file (images have none)",
        size=2, default=(0.0, 0.0), options={"SKIP_SAVE"},
    )  # fmt: skip
    height_nm: FloatProperty(
        name="Height (nm)",
        description="Height range in nanometres; 0 takes it from the file (images have none)",
        default=0.0,
        options={"SKIP_SAVE"},
    )
    channel: StringProperty(
        name="Channel", description="Name or number of the channel; empty finds the heights", options={"SKIP_SAVE"}
    )
    trust_units: BoolProperty(
        name="Trust Units",
        description="Take sides above 10 mm and heights above 1 mm from the file, which are refused otherwise",
        options={"SKIP_SAVE"},
    )
    flip_x: BoolProperty(name="Flip X", description="Exchange left and right", options={"SKIP_SAVE"})
    flip_y: BoolProperty(name="Flip Y", description="Exchange bottom and top", options={"SKIP_SAVE"})
    turn: EnumProperty(
        name="Turn", description="Turn anticlockwise, after flipping", items=TURN_ITEMS, options={"SKIP_SAVE"}
    )

    _browsed = False

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not busy(cls)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Ask for a file, unless one was given."""
        if is_given(self, "filepath"):
            return Threaded.invoke(self, context, event)
        self._browsed = True
        folder = last_folder()
        if folder:
            self.filepath = os.path.join(folder, "")
        return ImportHelper.invoke(self, context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Scripts wait. The file browser ends in this call too, and goes on with progress and Esc."""
        if not self._browsed:
            return Threaded.execute(self, context)
        remember_folder(os.path.dirname(self.filepath))
        bpy.ops.diffraction.import_scan("INVOKE_DEFAULT", **self.as_keywords(ignore=("check_existing", "filter_glob")))
        return {"CANCELLED"}  # of this call; the other one reports and pushes the undo step

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Read and store."""
        width, height = (decimal(size) * 1e-6 for size in self.size_um)
        size_m = (width, height) if any(self.size_um) else None
        height_m = decimal(self.height_nm) * 1e-9 if self.height_nm else None
        placement = scan_store.Placement(self.flip_x, self.flip_y, int(self.turn))
        path, folder = Path(bpy.path.abspath(self.filepath)), paths.data_folder()
        channel, trusted = self.channel or None, self.trust_units
        return [
            Job(lambda done: scan_store.import_scan(folder, path, size_m, height_m, channel, placement, done, trusted))
        ]


class DIFFRACTION_OT_choose_channel(_Takes, bpy.types.Operator):
    """Read another channel of the imported file"""

    bl_idname = "diffraction.choose_channel"
    bl_label = "Channel"
    bl_options = {"REGISTER", "UNDO"}

    def _items(self: Any, context: Any) -> list[tuple[str, str, str]]:
        names = json.loads(context.scene.diffraction.channels or "[]") if context is not None else []
        _kept_items[:] = [(str(index), name, "") for index, name in enumerate(names)]
        return _kept_items

    channel: EnumProperty(name="Channel", description="Channels of the imported file", items=_items)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        state = context.scene.diffraction
        if len(json.loads(state.channels or "[]")) < 2:
            cls.poll_message_set("The scan has no other channel")
            return False
        if not Path(json.loads(state.imported or "{}").get("path", "")).is_file():
            cls.poll_message_set("The file that the scan was imported from is gone")
            return False
        return not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Read and store."""
        before = json.loads(context.scene.diffraction.imported)
        size_m = tuple(before["size_m"]) if "size_m" in before else None
        path, folder, channel = Path(before["path"]), paths.data_folder(), self.channel
        # A height range belongs to one channel only.
        trusted = bool(before.get("trust_units"))

        def take(done: Progress) -> scan_store.Stored:
            return scan_store.import_scan(folder, path, size_m, None, channel, progress=done, trusted=trusted)

        return [Job(take)]


class DIFFRACTION_OT_use_stored_scan(_Takes, bpy.types.Operator):
    """Go back to a scan that was stored with this file"""

    bl_idname = "diffraction.use_stored_scan"
    bl_label = "Stored Scan"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the stored scan, without .gsf")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not scan_store.stored_scans():
            cls.poll_message_set("No scan is stored with this file yet")
            return False
        return not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Read it."""
        found = [path for path in scan_store.stored_scans() if path.stem == self.name]
        if not found:
            raise ScanError(f"There is no stored scan '{self.name}'; import it.")
        return [Job(lambda _: scan_store.stored(found[0]))]


CLASSES = (DIFFRACTION_OT_import_scan, DIFFRACTION_OT_choose_channel, DIFFRACTION_OT_use_stored_scan)
