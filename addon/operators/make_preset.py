# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a preset structure the scene's scan."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty

from ...precompute.presets import PRESETS, look_of, make_preset
from .. import paths, preset_properties, properties
from ..given import is_given, take
from ..jobs.job import Job, Progress
from ..jobs.threaded import Threaded, busy
from ..numbers import decimal
from ..tables import bake_settings, scan_store


class DIFFRACTION_OT_make_preset(Threaded, bpy.types.Operator):
    """Take a structure that needs no microscope"""

    bl_idname = "diffraction.make_preset"
    bl_label = "Use Preset"
    bl_options = {"REGISTER", "UNDO", "PRESET"}
    title = "Making the structure"

    preset: EnumProperty(
        name="Preset", description="A structure that needs no microscope", items=preset_properties.ITEMS
    )
    size_um: properties.preset_size()
    pixels: properties.preset_pixels()
    look: BoolProperty(
        name="Look",
        description="Also set what suits the structure: orientation, Fresnel, levelling, ensemble, coherence, patch",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return not busy(cls)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        for name in ("preset", *(p.name for p in PRESETS[self.preset].parameters), "size_um", "pixels", "look"):
            layout.prop(self, name)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """By a button or the search a person chooses a look; scripts say ``look=True``."""
        if not is_given(self, "look"):
            self.look = True
        return Threaded.invoke(self, context, event)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """Make and store."""
        state = context.scene.diffraction
        take(self, state, ("preset",))
        take(self, state, ("size_um", "pixels"), "preset_")
        name, values = self.preset, {}
        names = [parameter.name for parameter in PRESETS[name].parameters]
        take(self, getattr(state.presets, name), names)  # presets that share a parameter have each its own
        for each in names:
            value = getattr(self, each)
            values[each] = decimal(value) if isinstance(value, float) else value
        size_um, pixels, folder = decimal(self.size_um), self.pixels or None, paths.data_folder()
        if self.look and not size_um:  # a patch on which the look's coherence window fits
            size_um, pixels = look_of(name).patch_um, pixels or look_of(name).patch_pixels or None
        size_m = size_um * 1e-6 or None

        def work(progress: Progress) -> Any:
            return scan_store.store_preset(folder, name, lambda: make_preset(name, size_m, pixels, **values), progress)

        return [Job(work)]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """The scene shows the structure."""
        (scan,) = results
        scan_store.adopt(context.scene, scan)
        context.scene.diffraction.preset = self.preset
        if self.look:
            _set_look(context.scene.diffraction, self.preset)
        return f"{PRESETS[self.preset].label}: {scan.info}"


def _set_look(state: bpy.types.PropertyGroup, name: str) -> None:
    """What suits a preset; no step of the levelling that was meant for an earlier scan stays."""
    for each in bake_settings.LEVELLING:
        state.property_unset(each)
    for key, value in look_of(name).settings().items():
        setattr(state, key, value)


DIFFRACTION_OT_make_preset.__annotations__.update(preset_properties.all_parameters())

CLASSES = (DIFFRACTION_OT_make_preset,)
