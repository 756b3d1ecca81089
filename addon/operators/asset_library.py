# SPDX-License-Identifier: GPL-3.0-or-later
"""A button that makes the asset library, in a second Blender, and registers it in the preferences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
from bpy.props import EnumProperty, StringProperty

from ...precompute.errors import ParameterError
from .. import paths, properties, renderers
from ..assets import library, worker
from ..given import is_given
from ..jobs.job import Job
from ..jobs.threaded import Threaded, busy

#: Name of the library in the preferences.
NAME = "Diffraction"


class DIFFRACTION_OT_make_asset_library(Threaded, bpy.types.Operator):
    """Bake ready materials with previews into an asset library, in the background, and show it in asset browsers"""

    bl_idname = "diffraction.make_asset_library"
    bl_label = "Make Asset Library"
    title = "Asset library"

    directory: StringProperty(
        name="Folder",
        description="Where the library goes; empty takes a folder of the extension's own",
        subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )
    implementation: EnumProperty(
        name="Implementation",
        description="What renders the materials",
        items=properties.IMPLEMENTATION_ITEMS,
        default="AUTO",
        options={"SKIP_SAVE"},
    )

    only: StringProperty(
        name="Only",
        description="Names of presets, separated by commas, whose materials are made; empty makes all",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """One: watch the other Blender."""
        implementation = self.implementation if is_given(self, "implementation") else "AUTO"
        if implementation == "AUTO":
            implementation = renderers.choose(context.scene)[0]
        folder = Path(bpy.path.abspath(self.directory)) if self.directory else paths.asset_folder()
        only = tuple(name.strip() for name in self.only.split(",") if name.strip())
        unknown = [name for name in only if name not in {asset.preset for asset in library.ASSETS}]
        if unknown:
            raise ParameterError(f"There is no material of {', '.join(unknown)}; take names of presets.")
        command = worker.command(folder / "materials.blend", implementation, only)
        if not command:
            raise ParameterError("Blender as a module cannot start a second one: run sample_blend/build_assets.py.")
        self._folder = folder
        return [Job(lambda progress: worker.run(command, progress))]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The library is registered, once."""
        libraries = bpy.context.preferences.filepaths.asset_libraries
        known = [each for each in libraries if each.path and Path(each.path).resolve() == self._folder.resolve()]
        if not known:
            libraries.new(name=NAME, directory=str(self._folder))
        return f"{results[0]} materials are in the asset library {known[0].name if known else NAME}"


CLASSES = (DIFFRACTION_OT_make_asset_library,)
