# SPDX-License-Identifier: GPL-3.0-or-later
"""Stage 4: from the table to the surfaces."""

from __future__ import annotations

import re
from typing import Any

import bpy

from .. import paths, renderers
from ..lights import keyed, light_list
from ..materials import material, scale, setup, travel
from ..operators.apply_material import closure_bytes
from ..operators.files import farm_copies, is_fresh
from ..tables.table_state import READY, table_state
from ..versions import EEVEE
from ..watch import slots
from ..watch.misfits import misfits, why
from ..watch.places import tables
from .bake import scene_table
from .sidebar import Sidebar, Stage, button, file_name, megabytes, note, number, split


class DIFFRACTION_PT_material(Stage, bpy.types.Panel):
    """From the table to the surfaces"""

    bl_label = "Material"
    bl_order = 4

    def draw(self, context: bpy.types.Context) -> None:
        layout, state = split(self.layout), context.scene.diffraction
        layout.prop(state, "implementation")
        implementation = state.implementation
        if implementation == "AUTO":
            implementation, reason = renderers.choose(
                context.scene, False, closure_bytes(context, False, state.environment)
            )
            note(layout, f"{'OSL' if implementation == 'OSL' else 'Nodes'}: {reason}")
        if implementation == "NODES" and context.scene.render.engine == EEVEE:
            note(layout, "EEVEE shows four lamps, by their middle; Cycles shows all light")
        inside = scene_table(context.scene).info.get("stack")
        if inside:
            note(layout, f"Reflectance: {inside['text']}, from the table")
        else:
            layout.prop(state, "fresnel")
            if state.fresnel in {"DIELECTRIC", "SCHLICK"}:
                layout.prop(state, "ior")
        layout.prop(state, "orientation")
        active = context.object.data if context.object is not None and context.object.type == "MESH" else None
        if state.orientation in {"UV", "TEXTURE"} and active is not None:
            layout.prop_search(state, "uv_map", active, "uv_layers")
        if state.orientation == "ATTRIBUTE" and active is not None:
            layout.prop_search(state, "attribute", active, "attributes")
        if state.orientation == "TEXTURE":
            layout.prop_search(state, "angle_image", bpy.data, "images")
        layout.prop(state, "rotation")
        layout.prop(state, "conserve_energy")
        number(layout, state, "environment", "off")
        layout.operator("diffraction.apply_material", icon="MATERIAL")
        which = slots.only_active(ob for ob in context.selected_objects if slots.takes_material(ob))
        if which:
            note(layout, which)
            layout.operator("diffraction.apply_material", text="Apply to All Slots").all_slots = True
        if misfits(context.scene):
            note(layout, why(context.scene), "ERROR")
            layout.operator("diffraction.fit_renderer", icon="MODIFIER")
        for text in _scale(context):
            note(layout, text, "ERROR")


class DIFFRACTION_PT_assets(Sidebar, bpy.types.Panel):
    """Ready materials for the asset browser"""

    bl_label = "Asset Library"
    bl_parent_id = "DIFFRACTION_PT_material"
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 9

    def draw(self, context: bpy.types.Context) -> None:
        note(self.layout, "Snakes, discs, gratings and foils as ready materials with pictures; some minutes of work")
        button(self.layout, "diffraction.make_asset_library", icon="ASSET_MANAGER")


class DIFFRACTION_PT_active(Sidebar, bpy.types.Panel):
    """Live controls of the active object's material"""

    bl_label = "Active Material"
    bl_parent_id = "DIFFRACTION_PT_material"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        active = _active(context)
        return material.is_ours(active) and material.shader_node(active) is not None

    def draw(self, context: bpy.types.Context) -> None:
        draw_active(self.layout, _active(context))


def draw_active(layout: bpy.types.UILayout, active: bpy.types.Material) -> None:
    """What can be turned at a material of ours, and what is wrong with it."""
    layout.use_property_split = True
    layout.use_property_decorate = False
    node = material.shader_node(active)
    found = table_state(material.table_path(active))
    row = layout.row(align=True)
    row.label(text=active.name, icon="MATERIAL")
    row.operator("diffraction.use_material_scan", text="", icon="GREASEPENCIL")
    if found.kind == READY:
        packed = ", packed" if travel.is_packed(active) else ""
        note(layout, f"{travel.home(active).stem}: {found.summary}{packed}", "TEXTURE")
    else:
        note(layout, found.text, "ERROR")
        layout.operator("diffraction.rebake", icon="FILE_REFRESH").scope = "ACTIVE"
    if not active.is_editable:
        note(layout, "This material is linked from another file. Make it local to change it")
        layout.operator("diffraction.make_local", icon="LINKED")
        return
    if active.users - active.use_fake_user > 1 and bpy.context.scene.diffraction.table_path:
        row = layout.row()
        row.label(text=f"Shown by {active.users - active.use_fake_user} objects")
        row.operator("diffraction.apply_material", text="Own Copy", icon="DUPLICATE").own_copy = True
    _switches(layout, node)
    for name in material.LIVE_SOCKETS:
        socket = node.inputs.get(name)
        if socket is not None and not (socket.is_linked or socket.hide) and not _without_effect(name, node):
            layout.prop(socket, "default_value", text=re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name))
    for name in ("Scale", "Depth") if found.kind == READY else ():
        socket, most = node.inputs.get(name), found.info["layout"].get(f"{name.lower()}_headroom", 1.0)
        if socket is not None and not socket.is_linked and socket.default_value > most:
            note(layout, f"{name} above {most:.3g} passes the table: bake with {name} Headroom (Advanced)", "ERROR")


def _switches(layout: bpy.types.UILayout, node: Any) -> None:
    """Fresnel and energy, which the node keeps as numbers, as buttons."""
    path = f'object.active_material.node_tree.nodes["{node.name}"].inputs'
    fresnel, energy = (node.inputs.get(name) for name in ("Fresnel", "ConserveEnergy"))
    if fresnel is not None and not (fresnel.is_linked or fresnel.hide):
        row = layout.grid_flow(row_major=True, columns=2, even_columns=True, align=True)  # four in a line are cut off
        for value, text in ((3, "Dielectric"), (2, "Conductor"), (1, "Schlick"), (0, "All")):
            choice = row.operator("wm.context_set_int", text=text, depress=fresnel.default_value == value)
            choice.data_path, choice.value = f'{path}["Fresnel"].default_value', value
    if energy is not None and not energy.is_linked:
        icon = "CHECKBOX_HLT" if energy.default_value else "CHECKBOX_DEHLT"
        choice = layout.operator("wm.context_set_int", text="Conserve Energy", icon=icon)
        choice.data_path, choice.value = f'{path}["ConserveEnergy"].default_value', 1 - energy.default_value


def _without_effect(name: str, node: Any) -> bool:
    """Whether a socket does nothing here: a conductor has no index of refraction."""
    return name == "IOR" and node.inputs["Fresnel"].default_value not in (1, 3)


class DIFFRACTION_PT_material_tab(bpy.types.Panel):
    """Diffraction of the material that the properties editor shows"""

    bl_label = "Diffraction"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return context.object is not None and context.object.type in {"MESH", "CURVE", "SURFACE", "META", "FONT"}

    def draw(self, context: bpy.types.Context) -> None:
        layout, active = self.layout, getattr(context, "material", None)
        if material.is_ours(active) and material.shader_node(active) is not None:
            draw_active(layout, active)
            return
        if context.scene.diffraction.table_path:
            note(layout, f"Shows the table {file_name(context.scene.diffraction.table_path)}")
            layout.operator("diffraction.apply_material", text="Add Diffraction", icon="MATERIAL")
        else:
            note(layout, "Scan, preset and bake are in the 3-D view's sidebar (key N), tab Diffraction")


class DIFFRACTION_PT_files(Sidebar, bpy.types.Panel):
    """The tables of this file: their memory, and whether they are there"""

    bl_label = "Files"
    bl_parent_id = "DIFFRACTION_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return material.any_ours()

    def draw(self, context: bpy.types.Context) -> None:
        layout, total, broken, outside, linked = self.layout, 0, False, False, False
        for place, users in tables().items():
            found = table_state(material.table_path(users[0]))
            total += found.texture_bytes
            ready = found.kind == READY
            broken |= not ready
            outside |= ready and users[0].is_editable and place.parent != paths.data_folder()
            linked |= any(not is_fresh(here, there) for each in users for there, here in farm_copies(each).items())
            size = megabytes(found.texture_bytes) if ready else found.kind.title()
            count = f"{len(users)} material{'s' * (len(users) != 1)}"
            note(layout, f"{file_name(place.name)}: {size}, {count}", "TEXTURE" if ready else "ERROR")
        layout.label(text=f"{megabytes(total)} of texture in all")
        if light_list.written_slots(context.scene) or keyed.is_baked(context.scene):
            note(layout, "Instances bring lamps: without this extension a renderer needs keys for them", "LIGHT")
            layout.operator("diffraction.bake_lights", icon="KEYFRAME")
        if broken:
            layout.operator("diffraction.rebake", text="Bake Broken Again", icon="FILE_REFRESH").scope = "BROKEN"
            layout.operator("diffraction.find_files", icon="VIEWZOOM")
        if outside:
            note(layout, "Some tables lie outside the folder of this .blend and will not move with it")
        if linked:
            note(layout, "Without this extension a renderer would not find the tables of linked materials")
        if outside or linked:
            layout.operator("diffraction.collect_files", icon="FILE_PARENT")
        if bpy.data.filepath and travel.beside(paths.absolute("//")):
            note(layout, "This file needs its folder diffraction/, or carries the tables inside")
            layout.operator("diffraction.pack", icon="PACKAGE")
        if bpy.ops.diffraction.unpack.poll():
            layout.operator("diffraction.unpack", icon="UGLYPACKAGE")


class DIFFRACTION_PT_settings(Sidebar, bpy.types.Panel):
    """Settings of Blender that the materials need and that Apply changed"""

    bl_label = "Changed Settings"
    bl_parent_id = "DIFFRACTION_PT_material"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return bool(setup.changes(context.scene))

    def draw(self, context: bpy.types.Context) -> None:
        for text in setup.changes(context.scene):
            self.layout.label(text=text, icon="CHECKMARK")
        self.layout.operator("diffraction.restore_settings", icon="LOOP_BACK")


def _active(context: bpy.types.Context) -> Any:
    return context.object.active_material if context.object is not None else None


def _scale(context: bpy.types.Context) -> list[str]:
    """Warnings for the active object, with what the scene's table was baked with."""
    found = scene_table(context.scene)
    if found.kind != READY:
        return []
    chosen, source = found.info.get("parameters", {}), found.info.get("source", {})
    sigma_s = chosen.get("sigma_s_m") or 0.0
    patch = max(source.get("size_m") or [0.0])
    return scale.warnings(context.scene, context.object, chosen.get("ensemble", "average"), sigma_s, patch)


CLASSES = (
    DIFFRACTION_PT_material,
    DIFFRACTION_PT_active,
    DIFFRACTION_PT_files,
    DIFFRACTION_PT_settings,
    DIFFRACTION_PT_assets,
    DIFFRACTION_PT_material_tab,
)
