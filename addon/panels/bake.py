# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 3: from the heights to a table of colours."""

from __future__ import annotations

from typing import Any

import bpy

from ...precompute.errors import DiffractionError
from ...precompute.table.facts import energy_lines
from .. import paths
from ..jobs import progress
from ..operators.setting_presets import DIFFRACTION_MT_bake_presets
from ..tables import bake_settings, estimates, light_file, stack_preview
from ..tables.table_state import NONE, READY, TableState, table_state, texture_bytes
from .sidebar import Sidebar, Stage, button, duration, file_name, megabytes, note, number, split, vector


class DIFFRACTION_PT_bake(Stage, bpy.types.Panel):
    """From the heights to a table of colours"""

    bl_label = "Bake"
    bl_order = 3

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        row = self.layout.row(align=True)
        row.menu(DIFFRACTION_MT_bake_presets.__name__, text="", icon="PRESET")
        row.operator("diffraction.bake_preset_add", text="", icon="ADD")

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        column = layout.column()
        column.enabled = progress.running() is None
        column.prop(state, "ensemble")
        if state.ensemble == "periodic":
            vector(column, state, "replicas")
        else:
            number(column, state, "sigma_s_um", "auto")
            column.operator("diffraction.coherence_of_sunlight", icon="LIGHT_SUN")
        column.prop(state, "detail")
        column.prop(state, "error_percent")
        if state.scan_path:
            _estimate(layout, context.scene)
        found = scene_table(context.scene)
        again = found.kind != NONE
        button(layout, "diffraction.bake", icon="RENDER_STILL", text="Bake Again" if again else "Bake")
        _table(layout, state, found)


class DIFFRACTION_PT_bake_stuff(Sidebar, bpy.types.Panel):
    """What the surface is made of: its reflectance goes into the table"""

    bl_label = "Material of the Surface"
    bl_parent_id = "DIFFRACTION_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        layout.enabled = progress.running() is None
        for name in ("substrate", "films", "lacquer"):
            layout.prop(state, name)
        try:
            made = bake_settings.stuff(state.substrate, state.films, state.lacquer)
        except DiffractionError as error:
            note(layout, str(error), "ERROR")
            return
        if made["stack"] is not None:
            layout.prop(state, "stack_colour")
            icon, said = stack_preview.plot(state.substrate, state.films, state.lacquer)
            if icon:
                self.layout.template_icon(icon_value=icon, scale=11.0)
            note(self.layout, f"{said}. To the right nm, upwards degrees; the right edge: its colour in daylight")
            for text in made["stack"].notes:
                note(layout, text)


class DIFFRACTION_PT_bake_advanced(Sidebar, bpy.types.Panel):
    """Less needed options of the bake"""

    bl_label = "Advanced"
    bl_parent_id = "DIFFRACTION_PT_bake"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        layout.enabled = progress.running() is None
        layout.prop(state, "table_name")
        layout.prop(state, "illuminant")
        if state.illuminant == light_file.FILE:
            _light(layout, state)
        for name in ("series", "tolerance", "energy", "scale_headroom", "depth_headroom", "limit_mb"):
            layout.prop(state, name)


def _light(layout: bpy.types.UILayout, state: bpy.types.PropertyGroup) -> None:
    layout.prop(state, "illuminant_file")
    if light_file.lives_on_values(state):
        note(layout, "The file is gone; the values that were baked stand for it")
        return
    try:
        light_file.illuminant(state)
    except DiffractionError as error:
        note(layout, str(error), "ERROR")


def scene_table(scene: bpy.types.Scene) -> TableState:
    """State of the scene's own table."""
    path = scene.diffraction.table_path
    return table_state(paths.absolute(path) if path else None)


def _estimate(layout: bpy.types.UILayout, scene: bpy.types.Scene) -> None:
    found = estimates.estimate(scene)
    if found is None:
        layout.label(text="Estimating...", icon="TIME")
    elif found.error:
        note(layout, found.error, "ERROR")
    else:
        cost = found.cost
        column = layout.column(align=True)
        column.label(text=f"About {duration(estimates.seconds(found))}, {cost.nodes} terms", icon="TIME")
        column.label(text=f"{megabytes(cost.memory_bytes)} of memory to bake", icon="MEMORY")
        column.label(text=f"{megabytes(cost.disk_bytes)} on disk", icon="DISK_DRIVE")
        column.label(text=f"{megabytes(texture_bytes(cost.texel_bytes))} of texture to render", icon="TEXTURE")
        if cost.refined_bytes > cost.texel_bytes:
            most = megabytes(texture_bytes(cost.refined_bytes))
            note(column, f"Up to {most} where its error asks for more", "BLANK1")
        if scene.diffraction.ensemble != "periodic":
            window = found.coherence
            note(column, f"Coherence {window.sigma_s_m * 1e6:.3g} um, {window.limit}", "LIGHT_SUN")
            if window.warning:
                note(layout, window.warning, "ERROR")


def _table(layout: bpy.types.UILayout, state: Any, found: TableState) -> None:
    if found.kind == NONE:
        return
    if found.kind != READY:
        note(layout, f"{found.text}. Bake it again", "ERROR")
        return
    column = layout.column(align=True)
    note(column, file_name(state.table_path), "CHECKMARK")
    column.label(text=found.summary, icon="BLANK1")
    for line in energy_lines(found.info):
        note(column, f"Energy, {line}", "BLANK1")
    if found.info.get("albedo_max", 0.0) > 1.0 and not state.conserve_energy:
        note(column, "At grazing angles it would reflect more light than it gets: switch Conserve Energy on", "ERROR")
    changed = bake_settings.changed(state.table_recipe, state)
    if changed:
        note(
            layout,
            f"Changed since the bake: {', '.join(changed)}. The table shows the old ones until you bake",
            "ERROR",
        )


CLASSES = (DIFFRACTION_PT_bake, DIFFRACTION_PT_bake_stuff, DIFFRACTION_PT_bake_advanced)
