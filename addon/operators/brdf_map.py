# SPDX-License-Identifier: GPL-3.0-or-later
"""Look at a table: all directions of view for one direction of light."""

from __future__ import annotations

from typing import Any

import bpy

from .. import paths, pictures, properties
from ..given import take
from ..jobs.job import Job, Progress
from ..jobs.threaded import Threaded, busy
from ..numbers import decimal
from ..tables.table_state import READY, table_state


class DIFFRACTION_OT_brdf_map(Threaded, bpy.types.Operator):
    """Draw the BRDF of the scene's table towards all views into an image: x to the right, y up, grazing at the rim"""

    bl_idname = "diffraction.brdf_map"
    bl_label = "BRDF Map"
    bl_options = {"UNDO", "PRESET"}
    title = "BRDF map"

    theta: properties.map_theta()
    phi: properties.map_phi()
    size: properties.map_size()
    linear: properties.map_linear()

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return has_table(cls, context) and not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Load and evaluate, away from Blender."""
        take(self, context.scene.diffraction, ("theta", "phi", "size", "linear"), "map_")
        path = paths.absolute(context.scene.diffraction.table_path)
        folder = pictures.scratch_folder()
        theta, phi, size, linear = decimal(self.theta), decimal(self.phi), self.size, self.linear

        def work(progress: Progress) -> Any:
            from ...precompute.evaluate.directions import from_angles
            from ...precompute.evaluate.disc_map import brdf_map, map_to_srgb
            from ...precompute.light.colour import xyz_to_rgb
            from ...precompute.table.table import SpectralTable

            progress("read the table", 0.0)
            table = SpectralTable.load(path)
            progress("evaluate", 0.3)
            xyz = brdf_map(table, from_angles(theta, phi), size)
            progress("convert", 0.8)
            illuminant = table.light
            rgb = xyz_to_rgb(xyz, illuminant=illuminant) if linear else map_to_srgb(xyz, None, illuminant)
            return pictures.written(folder, rgb, linear)

        return [Job(work)]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The map becomes an image."""
        name = f"BRDF {paths.absolute(context.scene.diffraction.table_path).stem}"
        pictures.show_file(context, name, results[0])
        context.scene.diffraction.map_image = name
        return f"The image '{name}' shows the map; open it in an image editor"


def has_table(cls: type[bpy.types.Operator], context: bpy.types.Context) -> bool:
    """Whether the scene has a table that can be read; says on the button why not."""
    path = context.scene.diffraction.table_path
    if not path:
        cls.poll_message_set("Bake a table first")
        return False
    found = table_state(paths.absolute(path))
    if found.kind != READY:
        cls.poll_message_set(f"{found.text}; bake it again")
        return False
    return True


CLASSES = (DIFFRACTION_OT_brdf_map,)
