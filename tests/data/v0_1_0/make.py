# SPDX-License-Identifier: GPL-3.0-or-later
"""Files as version 0.1.0 made them, and what it made of them; `tests/support/v0_1_0.py` hands them to the tests.

Made once, with Blender 5.2 as a module, by the code of commit f889080 (and `zstd`)::

    git worktree add /tmp/v0_1_0 f889080
    .venv/bin/python tests/data/v0_1_0/make.py /tmp/v0_1_0

================================  =======================================================================
``diffraction/lobes.exr, .json``  a small table of known lobes, saved by 0.1.0
``.../lobes.importance.exr``      directions for the environment in 0.1.0's format; an even density, since
                                  that of the table would take 4 MB: right in the mean, only noisier
``osl.blend``                     a sphere of OSL: dielectric, frame from the UV map; sun, point and area
                                  lamp, grey world
``nodes.blend``                   the same in shader nodes: conductor, frame radial
``expected.json``                 the settings in each .blend, and what the table reads as
``osl.exr``, ``nodes.exr``        the pictures that 0.1.0 rendered of them, many samples
``bakes.json``                    of a few bakes the hash of all texels and some of them
================================  =======================================================================
"""

import hashlib
import importlib.util
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

OLD = Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else None
HERE = Path(__file__).resolve().parent

#: Bakes whose texels are remembered: preset, side, pixels, parameters.
BAKES = {
    "average": ("sinusoid", 6e-6, 80, {"sigma_s_m": 0.6e-6, "detail": 0.2, "level": "plane"}),
    "single": ("blazed", 6e-6, 80, {"sigma_s_m": 0.6e-6, "ensemble": "single", "detail": 0.2}),
    "periodic": ("cd", 4.5e-6, 60, {"ensemble": "periodic", "replicas": (3, 2), "detail": 0.2}),
    "chebyshev": ("snake", 6e-6, 80, {"sigma_s_m": 0.6e-6, "series": "chebyshev", "detail": 0.2, "clip_percent": 99.0}),
}

#: Pixels a side, and samples of the pictures.
SIZE, SAMPLES = 24, 4096


def baked(atlas, seed=5, count=60):
    """What is remembered of an atlas: the hash of its half floats, and some texels with their places."""
    import numpy as np

    half = np.ascontiguousarray(atlas.astype("<f2"))
    rng = np.random.default_rng(seed)
    rows, columns = rng.integers(half.shape[0], size=count), rng.integers(half.shape[1], size=count)
    return {
        "shape": list(half.shape),
        "sha256": hashlib.sha256(half.tobytes()).hexdigest(),
        "texels": half[rows, columns].astype(float).tolist(),
    }


def read_as(table):
    """What a table reads as: its atlas, T and the albedo at places of a fixed draw."""
    import numpy as np

    rng = np.random.default_rng(2)
    u, v, w = rng.uniform(-1, 1, 20), rng.uniform(-1, 1, 20), rng.uniform(-2, -0.02, 20)
    directions = rng.normal(size=(20, 3))
    directions[:, 2] = np.abs(directions[:, 2])
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    return {
        "atlas": hashlib.sha256(np.ascontiguousarray(table.atlas.astype("<f4")).tobytes()).hexdigest(),
        "transform": np.asarray(table.transform(u, v, w), float).tolist(),
        "albedo": np.asarray(table.albedo(directions), float).tolist(),
    }


def bake_all(bake, make_preset, parameters):
    """What is remembered of each of `BAKES`, by the code that is given."""
    return {
        name: baked(bake(make_preset(preset, side, pixels), parameters(**options)).atlas)
        for name, (preset, side, pixels, options) in BAKES.items()
    }


def old_package():
    """The add-on of the old checkout."""
    spec = importlib.util.spec_from_file_location(
        "diffraction_shader", OLD / "__init__.py", submodule_search_locations=[str(OLD)]
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules["diffraction_shader"] = module
    spec.loader.exec_module(module)
    return module


def even_importance(path, sha256):
    """The image of `importance.save_importance`, with the same chance for all directions of every view."""
    import numpy as np
    import OpenEXR
    from diffraction_shader.precompute import importance

    edges = np.linspace(0, 1, importance.N_R + 1)
    radius = np.stack([edges[:-1], edges[1:], np.zeros(importance.N_R)], -1)
    turns = np.linspace(0, 1, importance.N_PHI + 1)
    turn = np.stack([turns[:-1], turns[1:], 0.5 * (turns[:-1] + turns[1:])], -1)
    row = np.concatenate([radius, np.tile(turn, (importance.N_ROWS, 1))])
    image = np.tile(row.astype(np.float32), (importance.HEIGHT, 1, 1))
    importance.save_importance(image, path, sha256, 2.0)
    with OpenEXR.File(str(path)) as file:
        header = {**file.header(), "compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.tiledimage}
    # One tile for all: equal rows then take next to nothing.
    tile = OpenEXR.TileDescription()
    tile.xSize, tile.ySize = image.shape[1], image.shape[0]
    header["tiles"] = tile
    for key in ("channels", "dataWindow", "displayWindow", "lineOrder"):
        header.pop(key, None)
    OpenEXR.File(header, {"RGB": image[::-1].copy()}).write(str(path))


def stage(bpy):
    """A sphere that fills an orthographic view, its rim (where f grows like 1 / cos) outside; lamps of three kinds."""
    import numpy as np
    from mathutils import Vector

    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, rotation=(0.9, 0.2, 0.4))
    sphere = bpy.context.object
    sphere.data.shade_smooth()
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 1.3, (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    for name, kind, place, energy in (
        ("sun", "SUN", (0.4, 0.3, 1.0), 3.0),
        ("point", "POINT", (-1.5, 0.5, 2.0), 80.0),
        ("area", "AREA", (0.3, -2.0, 1.6), 60.0),
    ):
        light = bpy.data.lights.new(name, kind)
        light.energy = energy
        if kind == "SUN":
            light.angle = 0.0
        elif kind == "POINT":
            light.shadow_soft_size = 0.1
        else:
            light.size = 0.6
        lamp = bpy.data.objects.new(name, light)
        lamp.location = place
        lamp.rotation_euler = Vector(place).to_track_quat("Z", "Y").to_euler()
        scene.collection.objects.link(lamp)
    world = bpy.data.worlds.new("world")
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.25, 0.3, 1.0)
    scene.world = world
    assert np.isfinite(sphere.matrix_world).all()
    bpy.context.view_layer.update()
    return sphere


def settings_of(bpy):
    """What the panel of an opened file shows, and what is remembered with its material."""
    state = bpy.context.scene.diffraction
    # Today the node's group knows the table, in 0.1.0 the material did.
    (owner,) = [each for each in (*bpy.data.materials, *bpy.data.node_groups) if "diffraction_table" in each]
    (material,) = [
        each for each in bpy.data.materials
        if owner == each or owner in [getattr(node, "node_tree", None) for node in each.node_tree.nodes]
    ]  # fmt: skip
    names = ("table_path", "scan_path", "sigma_s_um", "ensemble", "level", "detail", "illuminant", "preset")
    return {
        "scene": {name: getattr(state, name) for name in names},
        "material": {"name": material.name, "diffraction_table": owner["diffraction_table"]},
    }


def make_blend(bpy, folder, name, write_image, **options):
    """One .blend, its settings and its picture."""
    scenes = importlib.import_module("tests.addon.scenes")
    bpy.ops.wm.read_factory_settings(use_empty=True)
    sphere = stage(bpy)
    path = folder / f"{name}.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    state = bpy.context.scene.diffraction
    state.table_path = "//diffraction/lobes.exr"
    state.level, state.sigma_s_um, state.preset = "poly2", 2.5, "blazed"
    bpy.context.view_layer.objects.active = sphere
    sphere.select_set(True)
    assert bpy.ops.diffraction.apply_material(**options) == {"FINISHED"}
    sphere.active_material.name = "lobes"
    bpy.context.view_layer.update()
    image = scenes.render(SIZE, SAMPLES)
    write_image(HERE / f"{name}.exr", image)
    found = settings_of(bpy)
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=False)
    # Blender itself compresses lightly, and reads what is compressed harder.
    subprocess.run(["zstd", "-q", "-f", "--ultra", "-22", str(path), "-o", str(HERE / path.name)], check=True)
    return found


def write_image(path, image):
    """Half floats; row 0 of the array is the bottom."""
    import numpy as np
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(header, {"RGB": image[::-1].astype(np.float16)}).write(str(path))


def main():
    os.environ["BLENDER_USER_RESOURCES"] = tempfile.mkdtemp()
    import bpy

    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages"))
    package = old_package()
    package.register()
    sys.path.insert(0, str(OLD))
    from precompute.bake import bake
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset
    from precompute.table import SpectralTable, read_sidecar

    tables = importlib.import_module("tests.addon.tables")
    bakes = bake_all(bake, make_preset, BakeParameters)
    (HERE / "bakes.json").write_text(json.dumps(bakes, indent=None, sort_keys=True) + "\n")
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        table = folder / "diffraction" / "lobes.exr"
        table.parent.mkdir()
        tables.make_table(table, lambda u, v, w: 0.5 * tables.lobes(u, v, w), n_r=20, n_phi=32, n_w=4)
        even_importance(table.with_name("lobes.importance.exr"), read_sidecar(table)["atlas"]["sha256"])
        expected = {"table": read_as(SpectralTable.load(table))}
        expected["osl"] = make_blend(bpy, folder, "osl", write_image, implementation="OSL", environment=1)
        expected["nodes"] = make_blend(
            bpy, folder, "nodes", write_image, implementation="NODES", fresnel="CONDUCTOR", orientation="RADIAL"
        )
        (HERE / "diffraction").mkdir(exist_ok=True)
        for file in table.parent.iterdir():
            (HERE / "diffraction" / file.name).write_bytes(file.read_bytes())
    (HERE / "expected.json").write_text(json.dumps(expected, indent=1, sort_keys=True) + "\n")
    sys.stdout.flush()
    os._exit(0)  # Blender's own clean-up would say what the old add-on left registered


if __name__ == "__main__":
    main()
