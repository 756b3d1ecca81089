# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that are missing, old or elsewhere: say so, bake them again, find them, collect them."""

from __future__ import annotations

import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ...precompute.errors import DiffractionError, TableError
from ...precompute.files.atomic import atomic_path
from .. import paths
from ..jobs.job import Job
from ..jobs.threaded import Threaded, busy
from ..materials import material, refresh, travel
from ..materials.node import group, paint_nodes
from ..preferences import bake_device
from ..tables import bake_settings, recipe, scan_store
from ..tables.bake_job import BakeJob
from ..tables.table_state import READY, table_state
from ..watch import report
from ..watch.places import problems, tables

SCOPE_ITEMS = [
    ("BROKEN", "Broken", "Tables that are missing, damaged or of another release"),
    ("ACTIVE", "Active Material", "The table of the active object's material"),
    ("ALL", "All", "Every table that a material of this file uses"),
]


class DIFFRACTION_OT_check_files(bpy.types.Operator):
    """List tables that are missing, damaged or of another release, and what else keeps this scene from its colours"""

    bl_idname = "diffraction.check_files"
    bl_label = "Check Files"

    strict: BoolProperty(
        name="Strict",
        description="End with an error where anything is wrong: a RuntimeError for scripts",
        options={"SKIP_SAVE"},
    )

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = report.before_render(context.scene)
        for text in found:
            self.report({"WARNING"}, text)
        if not found:
            self.report({"INFO"}, f"All {len(tables())} tables are in place")
        elif self.strict:
            self.report({"ERROR"}, f"{len(found)} fault{'s' * (len(found) != 1)}: {'; '.join(found)}.")
            return {"CANCELLED"}
        return {"FINISHED"}


class DIFFRACTION_OT_rebake(Threaded, bpy.types.Operator):
    """Bake tables again, in place, from their stored scans and with the settings they were baked with"""

    bl_idname = "diffraction.rebake"
    bl_label = "Bake Again"
    bl_options = {"UNDO"}
    title = "Baking again"

    scope: EnumProperty(name="Scope", description="Which tables", items=SCOPE_ITEMS)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not any(material.is_ours(each) for each in bpy.data.materials):
            cls.poll_message_set("No material of this file has a table")
            return False
        return not busy(cls)

    def jobs(self, context: bpy.types.Context) -> list[Job]:
        """A bake for each table."""
        self._targets = self._chosen(context)
        if not self._targets:
            raise TableError("No table is broken; choose the active material or all tables to bake them again.")
        return [self._job(users[0], place) for place, users in self._targets]

    def finished(self, context: bpy.types.Context, results: list[Any]) -> str:
        """Materials and scenes of each table follow."""
        for (place, users), result in zip(self._targets, results, strict=True):
            made = group.owner(users[0]).get(recipe.KEY, "")
            if result.path == place:
                refresh.refresh(place, made)
            else:
                for each in users:
                    material.set_table(each, result.path)
                    group.owner(each)[recipe.KEY] = made
            for scene in bpy.data.scenes:
                state = scene.diffraction
                if state.table_path and paths.absolute(state.table_path) == place:
                    state.table_path, state.table_recipe = paths.relative(result.path), made
        return f"Baked {len(results)} table{'s' * (len(results) != 1)} again"

    def _chosen(self, context: bpy.types.Context) -> list[tuple[Path, list[bpy.types.Material]]]:
        active = context.object.active_material if context.object is not None else None
        chosen = []
        for place, users in tables().items():
            editable = [each for each in users if each.is_editable]
            broken = any(table_state(material.table_path(each)).kind != READY for each in editable)
            wanted = {"BROKEN": broken, "ACTIVE": active in users, "ALL": True}[self.scope]
            if editable and wanted:
                chosen.append((place, editable))
        return chosen

    def _job(self, user: bpy.types.Material, place: Path) -> BakeJob:
        made = travel.recipe_of(user)
        if not made:
            raise TableError(
                f"How the table {place.name} of {user.name} was made is not known; import its scan and bake it."
            )
        source, reading = recipe.scan_of(made, place.parent)
        known = bpy.context.scene.diffraction.bl_rna.properties
        defaults = {name: known[name].default for name in bake_settings.FIELDS}
        settings = SimpleNamespace(**{**defaults, **made.get("settings", {})})
        if settings.illuminant_data:
            settings.illuminant_file = ""  # as it was baked, whatever its file holds now
        # A path of another computer: the table moves beside this file.
        folder = place.parent if place.parent.is_dir() else paths.data_folder()
        return BakeJob(source, folder, place.stem, bake_settings.parameters(settings), reading, device=bake_device())


class DIFFRACTION_OT_find_files(bpy.types.Operator):
    """Look for missing tables in a folder and those below it"""

    bl_idname = "diffraction.find_files"
    bl_label = "Find Missing..."
    bl_options = {"REGISTER", "UNDO"}

    directory: StringProperty(name="Folder", description="Where to look", subtype="DIR_PATH")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not any(problems()):
            cls.poll_message_set("No table is missing")
            return False
        return True

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        folder = Path(bpy.path.abspath(self.directory))
        if not self.directory or not folder.is_dir():
            self.report({"ERROR"}, f"There is no folder '{self.directory}'; choose one that holds the tables.")
            return {"CANCELLED"}
        count = 0
        for each, _ in list(problems()):
            place = next((p for p in folder.rglob(travel.home(each).name) if table_state(p).kind == READY), None)
            if place is not None and each.is_editable:
                try:
                    material.set_table(each, place)
                except DiffractionError as error:
                    self.report({"WARNING"}, str(error))
                    continue
                count += 1
        self.report({"INFO"}, f"Found tables of {count} material{'s' * (count != 1)}")
        return {"FINISHED"} if count else {"CANCELLED"}


class DIFFRACTION_OT_collect_files(bpy.types.Operator):
    """Copy tables, paints and scans beside this .blend, so that its folder holds all it needs"""

    bl_idname = "diffraction.collect_files"
    bl_label = "Collect Files"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if not bpy.data.filepath:
            cls.poll_message_set("Save the .blend first")
            return False
        return not busy(cls)

    def execute(self, context: bpy.types.Context) -> set[str]:
        count = 0
        try:
            for scene in bpy.data.scenes:
                if scene.diffraction.scan_path:
                    scan_store.bring_here(scene)
            for place, users in tables().items():
                local = [each for each in users if each.is_editable]
                count += self._collect(context, place, local)
                for painted in filter(None, map(paint_nodes.image, local)):
                    self._collect_paint(painted)
                count += self._copy_linked([each for each in users if each.library is not None])
        except (DiffractionError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Copied {count} table{'s' * (count != 1)} to {paths.data_folder()}")
        return {"FINISHED"}

    def _collect(self, context: bpy.types.Context, place: Path, users: list[bpy.types.Material]) -> int:
        folder = paths.data_folder()
        if not users or place.parent == folder or table_state(material.table_path(users[0])).kind != READY:
            return 0
        there = material.table_path(users[0])
        target = _free(folder, place, there)
        for source in (there, there.with_suffix(".json")):
            _copy(source, target.with_suffix(source.suffix))
        scan = place.with_name(travel.recipe_of(users[0]).get("scan") or place.with_suffix(".gsf").name)
        if scan.is_file():
            _copy(scan, folder / scan.name)
        for scene in bpy.data.scenes:
            state = scene.diffraction
            if state.table_path and paths.absolute(state.table_path) == place:
                state.table_path = paths.relative(target)
        for each in users:
            made = group.owner(each).get(recipe.KEY)
            material.set_table(each, target)
            if made:
                group.owner(each)[recipe.KEY] = made
        return 1

    def _collect_paint(self, painted: bpy.types.Image) -> None:
        if painted.library is not None or painted.packed_file is not None or not painted.filepath:
            return
        there = paths.absolute(painted.filepath)
        target = paths.data_folder() / there.name  # a paint's name follows its content
        if there.is_file() and there != target:
            _copy(there, target)
            painted.filepath = paths.relative(target)

    def _copy_linked(self, users: list[bpy.types.Material]) -> int:
        count, folder = 0, paths.absolute("//")
        for there, here in {pair for each in users for pair in farm_copies(each).items()}:
            # A table that was baked here has its sidecar beside it, a copy for the farm has none.
            sidecar = here.with_name(here.stem.removesuffix(".importance") + ".json")
            if not here.is_relative_to(folder) or sidecar.is_file():
                self.report({"WARNING"}, f"{here} is another table or outside this folder: make the material local")
            elif not is_fresh(here, there):
                _copy(there, here)
                count += not here.stem.endswith(".importance")
        return count


def is_fresh(copy: Path, original: Path) -> bool:
    """Whether a copy is there and as new as its original."""
    return copy.is_file() and copy.stat().st_mtime >= original.stat().st_mtime


def farm_copies(linked: bpy.types.Material) -> dict[Path, Path]:
    """What to copy where so that a linked OSL material renders without this add-on; empty for others.

    Cycles takes a relative name in a socket for one beside the open file, of a linked material too, whose own name was
    meant from its library's folder.
    """
    if linked.library is None or material.shader_node(linked) is None or not material.needs_osl(linked):
        return {}
    found = [image.filepath for image in travel.images_of(linked) if image.filepath.startswith("//")]
    pairs = {paths.absolute(name, linked.library): paths.absolute(name) for name in found}
    return {there: here for there, here in pairs.items() if there != here and there.is_file()}


def _free(folder: Path, place: Path, there: Path) -> Path:
    """A name for a copy that takes no other table's place."""
    number = 0
    while True:
        target = folder / (place.name if not number else f"{place.stem}_{number}.exr")
        if not target.exists() or target.read_bytes() == there.read_bytes():
            return target
        number += 1


def _copy(source: Path, target: Path) -> None:
    if not target.exists() or not target.samefile(source):
        with atomic_path(target) as temporary:
            shutil.copyfile(source, temporary)


class DIFFRACTION_OT_use_material_scan(bpy.types.Operator):
    """Bring the active material's scan and bake settings back into the panels, to change and bake them again"""

    bl_idname = "diffraction.use_material_scan"
    bl_label = "Edit Table"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        active = context.object.active_material if context.object is not None else None
        if not material.is_ours(active):
            cls.poll_message_set("The active material has no table")
            return False
        if not travel.recipe_of(active):
            cls.poll_message_set("How this material's table was made is not known")
            return False
        return not busy(cls)

    def execute(self, context: bpy.types.Context) -> set[str]:
        assert context.object is not None and context.object.active_material is not None  # see `poll`
        active, state = context.object.active_material, context.scene.diffraction
        place, made = travel.home(active), travel.recipe_of(active)
        try:
            source, _ = recipe.scan_of(made, place.parent)
        except DiffractionError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        stored = place.parent / made["scan"]
        state.scan_path = paths.relative(stored if stored.is_file() else source)
        state.source_path, state.source_sha256 = made.get("source", ""), made.get("sha256", "")
        state.reading, state.scan_info = made.get("reading", "{}"), made.get("info", "")
        state.imported = state.channels = ""
        bake_settings.recall(made.get("settings", {}), state)
        state.table_path, state.table_recipe = paths.relative(place), group.owner(active)[recipe.KEY]
        state.table_name = place.stem if place.stem != Path(made["scan"]).stem else ""
        self.report({"INFO"}, f"{place.stem}: {state.scan_info}")
        return {"FINISHED"}


CLASSES = (
    DIFFRACTION_OT_check_files,
    DIFFRACTION_OT_rebake,
    DIFFRACTION_OT_find_files,
    DIFFRACTION_OT_collect_files,
    DIFFRACTION_OT_use_material_scan,
)
