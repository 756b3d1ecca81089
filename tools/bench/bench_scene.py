# SPDX-License-Identifier: GPL-3.0-or-later
"""Measure what the extension's handlers add to the life of a big scene: 20,000 objects, one of them moves.

`bench_scene.py [--objects N] [--rounds N]`

User CPU time of a view layer's update, with Blender's lists of handlers emptied and as the extension fills them, in
turn; medians of as many updates. Three things happen all the time: an object that is neither lamp nor instancer moves,
a mesh is edited, an animated frame is set. Merged into out/bench.json under "scene".
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))


def big_scene(count):
    """A scene of triangles and a sun, one triangle with a material of ours; the triangle that moves."""
    import bpy

    from tests.support.blender import scenes

    with tempfile.TemporaryDirectory() as folder:
        ours = scenes.plane_with_table(Path(folder))
        bpy.ops.diffraction.apply_material(implementation="NODES", environment=0)
        mesh = bpy.data.meshes.new("triangle")
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        mesh.materials.append(bpy.data.materials.new("grey"))
        for number in range(count):
            ob = bpy.data.objects.new("triangle", mesh)
            ob.location = (number % 100, number // 100, 0)
            bpy.context.scene.collection.objects.link(ob)
        ob.data = mesh.copy()
        for frame in (0, 100):
            ob.location.z = frame
            ob.keyframe_insert("location", frame=frame)
        other = bpy.data.objects.new("mover", mesh)
        bpy.context.scene.collection.objects.link(other)
        bpy.context.view_layer.update()
    assert ours.active_material is not None
    return ob, other


def steps(animated, mover):
    """What happens, by name: functions of the number of the round."""
    import bpy

    def moves(number):
        mover.location.x = number
        bpy.context.view_layer.update()

    def edit(number):
        animated.data.vertices[0].co.z = number
        animated.data.update()
        bpy.context.view_layer.update()

    def frame(number):
        bpy.context.scene.frame_set(number)

    return {"an object moves": moves, "a mesh is edited": edit, "an animated frame": frame}


def lists():
    """Blender's lists of handlers."""
    import bpy

    handlers = bpy.app.handlers
    return [where for where in (getattr(handlers, name) for name in dir(handlers)) if isinstance(where, list)]


def measure(step, rounds):
    """Medians in ms without and with handlers, rounds of each in turn."""
    held = [(where, list(where)) for where in lists()]
    taken = {False: [], True: []}
    for number in range(2 * rounds):
        for where, functions in held:
            where[:] = functions if number % 2 else []
        start = time.process_time()
        step(number)
        taken[bool(number % 2)].append(1e3 * (time.process_time() - start))
    return statistics.median(taken[False]), statistics.median(taken[True])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--objects", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=50)
    arguments = parser.parse_args()
    import bpy

    from tests.support.blender import extension
    from tools.bench.machine import warn_if_busy
    from tools.bench.results import merge

    extension.load().register()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    numbers = {"objects": arguments.objects}
    for name, step in steps(*big_scene(arguments.objects)).items():
        step(0)
        without, with_handlers = measure(step, arguments.rounds)
        numbers[name] = {"without_ms": without, "with_ms": with_handlers}
        print(
            f"{arguments.objects} objects, {name}: {without:.1f} ms without the extension's handlers,"
            f" {with_handlers:.1f} with them ({100 * (with_handlers / without - 1):+.1f} %), median of"
            f" {arguments.rounds}",
            flush=True,
        )
    numbers["quiet"] = warn_if_busy()
    merge("scene", numbers)
    sys.stdout.flush()
    os._exit(0)  # Blender as a module may crash at exit


if __name__ == "__main__":
    main()
