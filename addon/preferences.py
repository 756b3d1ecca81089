# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences of the extension: the device that bakes, and the cache of baked tables."""

from __future__ import annotations

import os
from pathlib import Path

import bpy

from ..precompute.constants import CACHE_LIMIT_BYTES
from ..precompute.errors import DiffractionError
from ..precompute.table.cache import TableCache
from .tables.gpu.device import ITEMS, renderer
from .versions import limits

_PACKAGE = __package__.rpartition(".")[0]


def cache_folder() -> Path:
    """The extension's own user folder, the only place outside the project that it may write to. Not made here."""
    if _PACKAGE.startswith("bl_ext."):
        return Path(bpy.utils.extension_path_user(_PACKAGE, path="cache"))
    return Path(bpy.utils.user_resource("DATAFILES", path="diffraction_shader")) / "cache"


def table_cache() -> TableCache | None:
    """The cache that the preferences ask for; None where it is off, cannot be made or there are no preferences."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    if addon is None or not addon.preferences.keep_tables:
        return None
    try:
        return TableCache(cache_folder(), addon.preferences.cache_limit_mb * 1_000_000)
    except DiffractionError:  # a bake without a cache is a bake all the same
        return None


def bake_device() -> str:
    """The device that bakes are to use, of `gpu_bake.device.ITEMS`."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    return addon.preferences.device if addon is not None else "AUTO"


#: Where a scan was imported from last, where there are no preferences to keep it.
_folder = ""


def last_folder() -> str:
    """Where a scan was imported from last; empty before the first, or where that folder is gone."""
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    folder = addon.preferences.scan_folder if addon is not None else _folder
    return folder if folder and os.path.isdir(folder) else ""


def remember_folder(folder: str) -> None:
    """A scan was imported from here."""
    global _folder
    addon = bpy.context.preferences.addons.get(_PACKAGE)
    _folder = folder
    if addon is not None:
        addon.preferences.scan_folder = folder


def _held() -> TableCache | None:
    """The cache if its folder exists."""
    return TableCache(cache_folder()) if cache_folder().is_dir() else None


def _shrink(preferences: bpy.types.AddonPreferences, context: bpy.types.Context) -> None:
    cache = table_cache()
    if cache is not None:
        cache.clean()


class DIFFRACTION_OT_clear_cache(bpy.types.Operator):
    """Remove all tables from the cache; tables beside your files stay"""

    bl_idname = "diffraction.clear_cache"
    bl_label = "Clear Cache"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        cache = _held()
        if cache is None or not cache.size_bytes():
            cls.poll_message_set("The cache is empty")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        cache = _held()
        if cache is not None:
            cache.clear()
        return {"FINISHED"}


class DIFFRACTION_AP_preferences(bpy.types.AddonPreferences):
    """What bakes, and how much is kept."""

    bl_idname = _PACKAGE

    keep_tables: bpy.props.BoolProperty(
        name="Keep Baked Tables",
        description="A second bake of the same scan with the same settings takes the table from the cache",
        default=True,
    )
    cache_limit_mb: bpy.props.IntProperty(
        name="Size Limit (MB)",
        description="The tables used longest ago are removed when the cache is larger than this",
        default=CACHE_LIMIT_BYTES // 1_000_000,
        min=10,
        soft_max=100_000,
        update=_shrink,
    )

    device: bpy.props.EnumProperty(
        name="Bake On", description="What computes the transforms of a bake", items=ITEMS, default="AUTO"
    )

    scan_folder: bpy.props.StringProperty(options={"HIDDEN"}, description="Where a scan was imported from last")

    def draw(self, context: bpy.types.Context) -> None:
        """A device, a switch, a limit, a button."""
        layout = self.layout
        layout.use_property_split = True
        layout.prop(self, "device")
        found = renderer()
        if found is None:
            note = "Blender has no GPU context here"
        else:
            note = found[0] if found[1] else f"{found[0]}: software, so Automatic takes the processor"
        layout.label(text=note, icon="INFO")
        for sentence in limits():
            layout.label(text=sentence, icon="INFO")
        layout.prop(self, "keep_tables")
        column = layout.column()
        column.active = self.keep_tables
        column.prop(self, "cache_limit_mb")
        cache = _held()
        row = layout.row()
        row.label(text=f"{(cache.size_bytes() if cache else 0) / 1e6:.0f} MB in the cache")
        row.operator(DIFFRACTION_OT_clear_cache.bl_idname, icon="TRASH")


CLASSES = (DIFFRACTION_OT_clear_cache, DIFFRACTION_AP_preferences)
