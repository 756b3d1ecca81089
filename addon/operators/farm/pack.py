# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry OSL tables inside the .blend, or beside it again; those of Nodes are always inside."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from ....precompute.errors import DiffractionError
from ....precompute.files.atomic import atomic_path
from ... import paths
from ...materials import material, travel
from ...materials.node import group


def _images(packed: bool) -> Iterator[bpy.types.Image]:
    """Images of editable OSL materials that are packed, or are not."""
    seen = set()
    for each in material.our_materials():
        if material.needs_osl(each):
            for image in travel.images_of(each):
                if image not in seen and (image.packed_file is not None) == packed:
                    seen.add(image)
                    yield image


class DIFFRACTION_OT_pack(bpy.types.Operator):
    """Carry the tables of OSL materials inside this .blend. Opened with this extension they are unpacked by themselves;
    without it only Nodes materials show their colours from there"""

    bl_idname = "diffraction.pack"
    bl_label = "Pack into .blend"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not any(_images(packed=False)):
            cls.poll_message_set("No OSL material has a table beside this file")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        count = 0
        for image in list(_images(packed=False)):
            try:
                image.pack()
            except RuntimeError as error:  # its file is gone
                self.report({"ERROR"}, str(error).strip())
                return {"CANCELLED"}
            count += 1
        travel.sync_all()
        self.report({"INFO"}, f"Packed {count} image{'s' * (count != 1)}; Bake Again packs the new table too")
        return {"FINISHED"}


class DIFFRACTION_OT_unpack(bpy.types.Operator):
    """Write packed tables of OSL materials beside this .blend, where a renderer without this extension reads them"""

    bl_idname = "diffraction.unpack"
    bl_label = "Unpack beside .blend"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not any(_images(packed=True)):
            cls.poll_message_set("No OSL material has a packed table")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        count = 0
        for image in list(_images(packed=True)):
            packed = image.packed_file
            assert packed is not None  # see `_images`
            try:
                with atomic_path(paths.absolute(image.filepath)) as temporary:
                    temporary.write_bytes(packed.data)
            except DiffractionError as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}
            image.unpack(method="REMOVE")  # the copy inside
            count += 1
        for each in material.our_materials():
            travel.write_sidecar(group.owner(each))
        travel.sync_all()
        self.report({"INFO"}, f"Wrote {count} image{'s' * (count != 1)} beside the .blend")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_pack, DIFFRACTION_OT_unpack)
