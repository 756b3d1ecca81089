# SPDX-License-Identifier: GPL-3.0-or-later
"""Give the selected objects a material that renders the scene's table."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...precompute.errors import DiffractionError
from .. import paths, properties, renderers
from ..given import is_given, take
from ..jobs import progress
from ..lights import gather
from ..materials import closures, handlers, material, setup
from ..versions import give_nodes, limits
from ..watch import slots

_FROM_PANEL = (
    "implementation",
    "fresnel",
    "ior",
    "conserve_energy",
    "orientation",
    "uv_map",
    "attribute",
    "angle_image",
    "rotation",
    "environment",
)


#: Kinds of data that a material is made of.
_KINDS = ("materials", "texts", "images", "node_groups")

#: Of a Blender that cannot.
NO_OSL = (
    "This Blender was built without Open Shading Language: set Implementation to Nodes or Automatic, or take a Blender"
    " from blender.org."
)


#: Of a step in a window, after which it may draw.
_STEP_SECONDS = 0.03


class DIFFRACTION_OT_apply_material(bpy.types.Operator):
    """Make the selected objects diffract; a material they have stays underneath as pigment"""

    bl_idname = "diffraction.apply_material"
    bl_label = "Apply"
    bl_options = {"REGISTER", "UNDO"}

    implementation: EnumProperty(
        name="Implementation",
        description="What renders the material",
        items=properties.IMPLEMENTATION_ITEMS,
        default="AUTO",
    )
    fresnel: EnumProperty(
        name="Fresnel",
        description="How much the surface reflects",
        items=properties.FRESNEL_ITEMS,
        default="DIELECTRIC",
    )
    ior: properties.ior()
    conserve_energy: BoolProperty(name="Conserve Energy", default=True)
    orientation: EnumProperty(
        name="Orientation", description="How the scan lies on the surface", items=properties.ORIENTATION_ITEMS
    )
    attribute: StringProperty(name="Attribute", description="Vector attribute of ATTRIBUTE")
    angle_image: StringProperty(name="Image", description="Image of TEXTURE")
    uv_map: StringProperty(name="UV Map", description="Whose tangent is the scan's x; empty takes the active one")
    rotation: FloatProperty(name="Rotation", description="Turn of the scan on the surface", subtype="ANGLE")

    environment: IntProperty(
        name="Environment", description="Random mirrors a sample for world, emitters and bounce light; 0: lamps only",
        default=1, min=0, max=8,
    )  # fmt: skip
    own_copy: BoolProperty(
        name="Own Copy",
        description="Leave a diffraction material that other objects share as it is, and change a copy of it",
        options={"SKIP_SAVE"},
    )

    all_slots: BoolProperty(
        name="All Slots",
        description="Every material slot of the selected objects diffracts, not the active ones alone",
        options={"SKIP_SAVE"},
    )

    dark_ground: BoolProperty(
        name="Dark Ground",
        description="Lay the colours over a dark pigment where the material is the untouched grey that Blender starts"
        " with: over grey they drown",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not context.scene.diffraction.table_path:
            cls.poll_message_set("Bake a table first")
            return False
        if not any(slots.takes_material(ob) for ob in context.selected_objects):
            cls.poll_message_set(slots.why_none(context.selected_objects))
            return False
        return True

    _steps: Generator[None, None, bpy.types.NodeTree]
    _timer: bpy.types.Timer | None = None
    _shows = False

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """A person wants to see the colours; scripts say ``dark_ground=True``. What takes long is done in steps."""
        if not is_given(self, "dark_ground"):
            self.dark_ground = True
        chosen = self._choose(context)
        if chosen is None:
            return {"CANCELLED"}
        if bpy.app.background:
            return self.execute(context)
        self._steps = material.table_group_in_steps(*chosen[:2])
        return self._go_on(context)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return self._go_on(context) if event.type == "TIMER" else {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender closes, or a file is loaded."""
        self._rest(context, False)

    def _go_on(self, context: bpy.types.Context) -> set[str]:
        """Prepare the table for a moment's time, and when all is there set up the materials."""
        rests, end = False, time.monotonic() + _STEP_SECONDS
        try:
            while time.monotonic() < end:
                next(self._steps)
            rests = True
        except (StopIteration, DiffractionError):
            pass  # what is wrong is told by `execute`, which comes to it again
        finally:
            self._rest(context, rests)
        return {"RUNNING_MODAL"} if rests else self.execute(context)

    def _rest(self, context: bpy.types.Context, rests: bool) -> None:
        """Wait for the next step, or no longer."""
        manager = context.window_manager
        if rests and self._timer is None:
            self._timer = manager.event_timer_add(0.01, window=context.window)
            manager.modal_handler_add(self)
            self._shows = progress.running() is None  # a bake may be at work
            if self._shows:
                progress.show("Applying", 0.5)
        elif not rests and self._timer is not None:
            manager.event_timer_remove(self._timer)
            self._timer = None
            if self._shows:
                progress.clear()

    def _choose(self, context: bpy.types.Context) -> tuple[Path, material.Settings, str] | None:
        """Table, settings, and why that implementation where it was left to us; None where it cannot be had."""
        take(self, context.scene.diffraction, _FROM_PANEL)
        implementation, why = self.implementation, ""
        if implementation == "AUTO":
            implementation, why = renderers.choose(
                context.scene, closure_bytes=closure_bytes(context, self.all_slots, self.environment)
            )
        elif implementation == "OSL" and not renderers.has_osl():
            self.report({"ERROR"}, NO_OSL)
            return None
        table = paths.absolute(context.scene.diffraction.table_path)
        return table, settings_from(self, implementation), why

    def execute(self, context: bpy.types.Context) -> set[str]:
        chosen = self._choose(context)
        if chosen is None:
            return {"CANCELLED"}
        table, settings, why = chosen
        implementation = settings.implementation
        context.view_layer.update()  # new lamps are not yet in the layer
        setup.take_up(context.scene)
        manager = context.window_manager
        manager.progress_begin(0.0, 1.0)  # a table's first material makes the image that directs rays, half a second
        try:
            targets = [ob for ob in context.selected_objects if slots.takes_material(ob)]
            places = slots.chosen(targets, self.all_slots)
            shared = _shared(places)
            copied = shared if self.own_copy else {}
            fresh = {each.material for each in places if self.dark_ground and untouched(each.material)}
            made = _make(places, copied, fresh, table.stem, lambda new: material.apply(new, table, settings))
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        finally:
            manager.progress_end()
        for place, new in [(each, made[each.material]) for each in places]:
            place.give(new)
        handlers.update_all()
        found = handlers.search(context.scene)
        notes = setup.prepare_scene(context.scene, implementation == "OSL")
        name = {"OSL": "OSL", "NODES": "Nodes"}[implementation]
        told = f"{len(made)} material{'s' * (len(made) != 1)} set up with {name}" + (f", because {why}" if why else "")
        if fresh:
            notes.append("a dark pigment in place of Blender's untouched grey")
        if not self.all_slots and slots.only_active(targets):
            notes.append(f"{slots.only_active(targets)}; All Slots below takes every one")
        self.report({"INFO"}, ". ".join([told, *notes]))
        for each, others in shared.items() if not self.own_copy else ():
            self.report({"WARNING"}, _changed_too(each, others))
        if not found.chosen and context.scene.world is None:
            self.report({"WARNING"}, "The scene has no lamp: add one to see the colours")
        for sentence in limits():
            self.report({"INFO"}, sentence)
        if found.left_out:
            self.report({"WARNING"}, gather.too_many(found))
        return {"FINISHED"}


def closure_bytes(context: bpy.types.Context, every: bool, mirrors: int) -> int:
    """What the selected objects' materials will take of OptiX's closures in OSL; 0 on any other device.

    Parameters
    ----------
    context
        Its scene and selection.
    every
        All slots of the objects, not the active one alone.
    mirrors
        Of the environment, a sample.
    """
    if not renderers.on_optix(context.scene):
        return 0
    targets = [ob for ob in context.selected_objects if slots.takes_material(ob)]
    shown = [place.material for place in slots.chosen(targets, every)]
    return closures.to_come(shown, len(handlers.search(context.scene).chosen), mirrors)


def settings_from(owner: Any, implementation: str) -> material.Settings:
    """The artist's choice, as an operator or the scene's group holds it.

    Parameters
    ----------
    owner
        Of the properties.
    implementation
        ``OSL`` or ``NODES``: what *Automatic* stood for.
    """
    return material.Settings(
        implementation=implementation,
        fresnel=owner.fresnel,
        ior=owner.ior,
        conserve_energy=owner.conserve_energy,
        orientation=owner.orientation,
        uv_map=owner.uv_map,
        attribute=owner.attribute,
        angle_image=owner.angle_image,
        rotation=owner.rotation,
        environment=owner.environment,
    )


def set_up(scene: bpy.types.Scene, shown: bpy.types.Material, table: Path, settings: material.Settings) -> list[str]:
    """Let one material show a table, and the scene have what that needs; what was changed, for people.

    Raises
    ------
    DiffractionError
        If the table cannot be used.
    """
    material.apply(shown, table, settings)
    handlers.update_all()
    return setup.prepare_scene(scene, settings.implementation == "OSL")


def _shared(places: list[slots.Slot]) -> dict[bpy.types.Material, list[bpy.types.Object]]:
    """Materials of ours that will change in place, with the objects beside the selected ones that show them."""
    found, targets = {}, {place.ob for place in places}
    for each in {place.material for place in places}:
        if material.is_ours(each) and each.is_editable:
            data = {ob.data for ob in targets}
            others = [
                ob for ob in bpy.data.objects
                if ob not in targets and ob.data not in data and any(s.material == each for s in ob.material_slots)
            ]  # fmt: skip
            if others:
                found[each] = others
    return found


def untouched(shown: bpy.types.Material | None) -> bool:
    """Whether a material is as Blender makes it: one Principled shader, every socket at its default."""
    tree = shown.node_tree if shown is not None else None
    if tree is None or len(tree.nodes) != 2 or shown is None or shown.animation_data is not None:
        return False
    shader = next((node for node in tree.nodes if node.bl_idname == "ShaderNodeBsdfPrincipled"), None)
    if shader is None or any(socket.is_linked for socket in shader.inputs) or tree.animation_data is not None:
        return False
    scratch = bpy.data.node_groups.new("scratch", "ShaderNodeTree")
    try:
        pristine = scratch.nodes.new("ShaderNodeBsdfPrincipled")
        return all(_value(a) == _value(b) for a, b in zip(shader.inputs, pristine.inputs, strict=True))
    finally:
        bpy.data.node_groups.remove(scratch)


def _value(socket: Any) -> Any:
    value: Any = getattr(socket, "default_value", None)
    return tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value


def _changed_too(each: bpy.types.Material, others: list[bpy.types.Object]) -> str:
    names = others[0].name if len(others) == 1 else f"{others[0].name} and {len(others) - 1} more"
    return f"{names} share{'s' * (len(others) == 1)} {each.name} and changed too; Own Copy below keeps them apart"


def _make(
    places: list[slots.Slot],
    copied: dict[bpy.types.Material, list[bpy.types.Object]],
    fresh: set[bpy.types.Material | None],
    stem: str,
    apply: Callable[[bpy.types.Material], bpy.types.Material],
) -> dict[bpy.types.Material | None, bpy.types.Material]:
    """New materials by old ones: objects that shared one share the new one. Where it fails nothing is left behind."""
    before = {kind: set(getattr(bpy.data, kind)) for kind in _KINDS}
    made = {}
    try:
        for old in dict.fromkeys(place.material for place in places):
            if material.is_ours(old) and old.is_editable and old not in copied:
                new = old
            elif old is not None and old not in fresh:
                new = old.copy()
                new.name = old.name if material.is_ours(old) else f"{old.name} diffraction"
            else:
                new = bpy.data.materials.new(f"Diffraction {stem}")
                give_nodes(new).nodes.clear()
            made[old] = apply(new)
    except Exception:
        bpy.data.batch_remove([each for kind in _KINDS for each in set(getattr(bpy.data, kind)) - before[kind]])
        raise
    return made


class DIFFRACTION_OT_restore_settings(bpy.types.Operator):
    """Give back the settings of scene, lamps and materials that Apply changed; diffraction then renders wrongly"""

    bl_idname = "diffraction.restore_settings"
    bl_label = "Restore Settings"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not setup.changes(context.scene):
            cls.poll_message_set("Nothing was changed")
            return False
        return True

    def execute(self, context: bpy.types.Context) -> set[str]:
        count = setup.restore_scene(context.scene)
        self.report({"INFO"}, f"Restored {count} setting{'s' * (count != 1)}; Apply sets them again")
        return {"FINISHED"}


CLASSES = (DIFFRACTION_OT_apply_material, DIFFRACTION_OT_restore_settings)
