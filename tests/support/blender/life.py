# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of a .blend's life, each in a Blender process of its own: `run(step, ...)`.

A step is a function of this module. It runs after the add-on is registered (unless `addon=False`) and returns what
JSON can hold.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

_MAIN = """
import json, os, sys
import bpy
from tests.support.blender import extension, life
bpy.ops.wm.read_factory_settings(use_empty=True)
name, addon, arguments = sys.argv[1], sys.argv[2] == "True", json.loads(sys.argv[3])
if addon:
    extension.load().register()
result = getattr(life, name)(**arguments)
print("\\nRESULT" + json.dumps(result), flush=True)
os._exit(0)
"""


def run(step, addon=True, user=None, **arguments):
    """Run a step in a fresh process and return its result.

    Parameters
    ----------
    step
        A function of this module.
    addon
        Whether the add-on is there.
    user
        Blender's user folder; a name of a folder that may not exist yet.
    """
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    if user is not None:
        Path(user).mkdir(exist_ok=True)
        environment["BLENDER_USER_RESOURCES"] = str(user)
    given = json.dumps({key: str(value) if isinstance(value, Path) else value for key, value in arguments.items()})
    done = subprocess.run(
        [sys.executable, "-c", _MAIN, step.__name__, str(addon), given],
        capture_output=True, text=True, cwd="/", env=environment, check=False,
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT")]
    assert lines, done.stdout + done.stderr
    return json.loads(lines[-1].removeprefix("RESULT"))


def open_file(path):
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)


def picture(size=16):
    """The scene's picture as nested lists, linear."""
    from tests.support.blender import scenes

    return scenes.render(size).round(6).tolist()


def sockets():
    """Absolute paths that each material's shader reads, and whether they are files."""
    import bpy

    from tests.support.blender import extension

    extension.load()  # to read what stands in the groups; nothing is registered by it
    from diffraction_shader.addon.materials.node import group

    found = {}
    for material in bpy.data.materials:
        tree = group.owner(material)
        node = group.script_of(tree) if tree is not None else None
        for name in ("Atlas", "Importance"):
            if node is not None and name in node.inputs:
                path = os.path.normpath(bpy.path.abspath(node.inputs[name].default_value, library=tree.library))
                found[f"{material.name} {name}"] = (path, os.path.isfile(path))
    return found


def states():
    """State of the table of each material of ours."""
    import bpy
    from diffraction_shader.addon.materials import material
    from diffraction_shader.addon.tables import table_state

    ours = [m for m in bpy.data.materials if material.is_ours(m)]
    return {m.name: table_state.table_state(material.table_path(m)).kind for m in ours}


# Steps.


def make_project(path, implementation="OSL"):
    """A .blend with a baked grating on a plane under a sun, all in the collection `show`."""
    import bpy

    from tests.support.blender import scenes

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=10, period_um=1.5)
    assert bpy.ops.diffraction.bake(detail=0.25) == {"FINISHED"}
    plane, sun = scenes.add_plane(), scenes.add_sun((0.35, 0.0, 0.93))
    scenes.add_camera()
    show = bpy.data.collections.new("show")
    scene.collection.children.link(show)
    for ob in (plane, sun):
        scene.collection.objects.unlink(ob)
        show.objects.link(ob)
    bpy.context.view_layer.update()
    plane.select_set(True)
    bpy.context.view_layer.objects.active = plane
    bpy.ops.diffraction.apply_material(fresnel="NONE", environment=0, implementation=implementation)
    plane.active_material.name = "grating"
    image = picture()
    bpy.ops.wm.save_mainfile()
    return image


def render_file(path):
    """Open and render."""
    open_file(path)
    return {"picture": picture(), "sockets": sockets()}


def check(path):
    """Open and look; the add-on brings things up to date by itself."""
    open_file(path)
    return {"states": states(), "sockets": sockets(), "picture": picture()}


def save_elsewhere(path, target, copy=False):
    """Save As (or a copy) into another folder."""
    import bpy

    open_file(path)
    bpy.ops.wm.save_as_mainfile(filepath=target, copy=copy)
    return {"sockets": sockets(), "scan": bpy.context.scene.diffraction.scan_path, "states": states()}


def append_to(path, target):
    """Append the collection into a new file in another folder, render and save it."""
    import bpy

    from tests.support.blender import scenes

    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.scene.cycles.shading_system = True
    bpy.ops.wm.save_as_mainfile(filepath=target)
    bpy.ops.wm.append(filepath=f"{path}/Collection/show", directory=f"{path}/Collection/", filename="show")
    scenes.add_camera()
    bpy.context.view_layer.update()
    image = picture()
    bpy.ops.wm.save_mainfile()
    return {"picture": image, "sockets": sockets(), "states": states()}


def link_to(path, target):
    """Link the collection into a new file in another folder, render and save it."""
    import bpy

    from tests.support.blender import scenes

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    bpy.ops.wm.save_as_mainfile(filepath=target)
    with bpy.data.libraries.load(path, link=True, relative=True) as (_, into):
        into.collections = ["show"]
    scene.collection.children.link(into.collections[0])
    scenes.add_camera()
    bpy.context.view_layer.update()
    image = picture()
    bpy.ops.wm.save_mainfile()
    return {"picture": image, "sockets": sockets(), "states": states()}


def link_and_collect(path, target):
    """Link the collection into a new file in another folder, save it and collect, twice."""
    import bpy

    from tests.support.blender.panels import shown, words

    link_to(path, target)
    before = words(shown("files"))
    outcomes = [sorted(bpy.ops.diffraction.collect_files()) for _ in range(2)]
    return {"outcome": outcomes[0], "again": outcomes[1], "before": before, "after": words(shown("files"))}


def collect_again(path):
    """Open and collect."""
    import bpy

    open_file(path)
    return {"outcome": sorted(bpy.ops.diffraction.collect_files())}


def paste_to(path, target):
    """Copy the plane in one file, paste it in another."""
    import bpy

    open_file(path)
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    plane = next(ob for ob in bpy.context.scene.objects if ob.type == "MESH")
    plane.select_set(True)
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.copybuffer()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=target)
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.view3d.pastebuffer()
    return {"sockets": sockets(), "states": states()}


def pack(path):
    """Pack everything and save."""
    import bpy

    open_file(path)
    bpy.ops.file.pack_all()
    bpy.ops.wm.save_mainfile()
    return {image.name: image.packed_file is not None for image in bpy.data.images if image.filepath}


def rebake(path, scope="BROKEN", forget_origin=False):
    """See what is broken, bake it again, save."""
    import bpy

    open_file(path)
    if forget_origin:
        from diffraction_shader.addon.materials.node import group

        owner = group.owner(bpy.data.materials["grating"])
        recipe = json.loads(owner["diffraction_recipe"])
        owner["diffraction_recipe"] = json.dumps({**recipe, "source": "/nowhere/sinusoid.gsf"})
    before = states()
    try:
        outcome = sorted(bpy.ops.diffraction.rebake(scope=scope))
    except RuntimeError as error:
        outcome = str(error)
    bpy.ops.wm.save_mainfile()
    return {"before": before, "after": states(), "outcome": outcome, "picture": picture()}


def undo(path):
    """Bake with other settings, give another object a material, and take both back."""
    import bpy

    from tests.support.blender import scenes

    open_file(path)
    state = bpy.context.scene.diffraction
    first = state.table_recipe
    bpy.ops.ed.undo_push(message="start")
    bpy.ops.diffraction.bake(detail=0.25, level="plane")
    changed = bpy.context.scene.diffraction.table_recipe != first
    bpy.ops.ed.undo_push(message="bake")
    ball = scenes.add_sphere(segments=16, rings=8)
    bpy.context.view_layer.update()
    for ob in bpy.context.scene.objects:
        ob.select_set(ob == ball)
    bpy.ops.diffraction.apply_material()
    bpy.ops.ed.undo_push(message="apply")
    count = len(bpy.data.materials)
    bpy.ops.ed.undo()
    after_one = len(bpy.data.materials)
    bpy.ops.ed.undo()
    back = bpy.context.scene.diffraction.table_recipe == first
    here = picture()
    bpy.ops.ed.redo()
    bpy.ops.ed.redo()
    return {
        "changed": changed, "back": back, "materials": [count, after_one, len(bpy.data.materials)],
        "states": states(), "picture": here, "sockets": sockets(),
    }  # fmt: skip


def collect(path, target):
    """Bake in a file that is not saved, save it, collect."""
    import bpy

    from tests.support.blender import scenes

    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=10)
    bpy.ops.diffraction.bake(detail=0.25)
    plane = scenes.add_plane()
    bpy.context.view_layer.update()
    plane.select_set(True)
    bpy.ops.diffraction.apply_material()
    poll_before = bpy.ops.diffraction.collect_files.poll()
    bpy.ops.wm.save_as_mainfile(filepath=target)
    outside = sockets()
    outcome = sorted(bpy.ops.diffraction.collect_files())
    bpy.ops.wm.save_mainfile()
    state = bpy.context.scene.diffraction
    return {
        "poll": poll_before, "outside": outside, "inside": sockets(), "outcome": outcome,
        "table": state.table_path, "scan": state.scan_path, "states": states(),
    }  # fmt: skip
