# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample scene: an iridescent snake in the sun.

``blender -b -P sample_blend/build_scene.py -- snake.blend`` (the extension enabled) bakes the preset, builds the scene
and saves it; ``build_scene`` alone builds it for other scripts.
"""

from __future__ import annotations

import importlib.util
import math
import sys
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

#: Near black: structural colours show where no pigment outshines them.
PIGMENT = (0.0030, 0.0024, 0.0022, 1.0)

#: Name, direction towards it, strength (W/m^2), angle (degrees), colour.
SUNS = (
    ("Sun", (-0.30, 0.62, 0.72), 36.0, 0.53, (1.0, 0.96, 0.9)),
    ("Window", (0.80, 0.15, 0.58), 17.0, 2.0, (0.85, 0.92, 1.0)),
)


def build_scene(material: bpy.types.Material | None = None, detail: float = 1.0) -> list[bpy.types.Object]:
    """Build the scene into the current one, whose objects are removed first.

    Parameters
    ----------
    material
        For the body. None gives it a plain dark pigment, selects it and makes it active, so that
        ``bpy.ops.diffraction.apply_material()`` can follow.
    detail
        Of the body's mesh; 1 gives about 700,000 faces.

    Returns
    -------
    list
        The objects that are to diffract: the body. The others are called Ground, Camera, Sun and Window.
    """
    scene = bpy.context.scene
    for ob in list(scene.objects):
        bpy.data.objects.remove(ob)
    body = _body(detail)
    body.data.materials.append(material or _plain("Pigment", PIGMENT))
    _ground()
    for sun in SUNS:
        _sun(*sun)
    scene.camera = _camera()
    _world(scene)
    _render_settings(scene)
    bpy.context.view_layer.update()
    for ob in scene.objects:
        ob.select_set(ob == body)
    bpy.context.view_layer.objects.active = body
    return [body]


def _body(detail: float) -> bpy.types.Object:
    points, quads, uv = _snake_mesh().build(detail)
    mesh = bpy.data.meshes.new("Snake")
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", uv.astype(np.float32).ravel())
    mesh.shade_smooth()
    return _link(bpy.data.objects.new("Snake", mesh))


def _snake_mesh():
    """The neighbouring file, found without an entry in sys.path."""
    path = Path(__file__).resolve().with_name("snake_mesh.py")
    spec = importlib.util.spec_from_file_location("diffraction_sample_snake_mesh", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _ground() -> bpy.types.Object:
    mesh = bpy.data.meshes.new("Ground")
    mesh.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
    material = _plain("Earth", (0.0075, 0.0058, 0.0045, 1.0))
    nodes, links = material.node_tree.nodes, material.node_tree.links
    noise, ramp, place = (nodes.new(f"ShaderNode{name}") for name in ("TexNoise", "Bump", "TexCoord"))
    noise.inputs["Scale"].default_value = 9.0
    noise.inputs["Detail"].default_value = 9.0
    ramp.inputs["Strength"].default_value = 0.6
    ramp.inputs["Distance"].default_value = 0.05
    links.new(place.outputs["Object"], noise.inputs["Vector"])
    links.new(noise.outputs[0], ramp.inputs["Height"])
    links.new(ramp.outputs["Normal"], nodes["Shader"].inputs["Normal"])
    mesh.materials.append(material)
    return _link(bpy.data.objects.new("Ground", mesh))


def _give_nodes(block: bpy.types.Material | bpy.types.World) -> None:
    """Blender 4.5 makes them only on request."""
    if block.node_tree is None:
        block.use_nodes = True


def _plain(name: str, colour: tuple[float, float, float, float]) -> bpy.types.Material:
    material = bpy.data.materials.new(name)
    _give_nodes(material)
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeBsdfDiffuse"), nodes.new("ShaderNodeOutputMaterial")
    shader.name = "Shader"
    shader.inputs["Color"].default_value = colour
    shader.location = (-240, 0)
    material.node_tree.links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    return material


def _sun(name: str, direction: tuple, strength: float, angle_deg: float, colour: tuple) -> bpy.types.Object:
    light = bpy.data.lights.new(name, "SUN")
    light.energy, light.color, light.angle = strength, colour, math.radians(angle_deg)
    ob = bpy.data.objects.new(name, light)
    ob.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
    ob.location = Vector(direction).normalized() * 4
    return _link(ob)


def _camera() -> bpy.types.Object:
    data = bpy.data.cameras.new("Camera")
    data.lens = 78
    ob = bpy.data.objects.new("Camera", data)
    ob.location = (0.35, -2.35, 1.75)
    look = Vector((0.06, -0.06, 0.08)) - Vector(ob.location)
    ob.rotation_euler = look.to_track_quat("-Z", "Y").to_euler()
    return _link(ob)


def _world(scene: bpy.types.Scene) -> None:
    world = bpy.data.worlds.new("Dusk")
    _give_nodes(world)
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.10, 0.13, 0.18, 1.0)
    world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.4
    scene.world = world


def _render_settings(scene: bpy.types.Scene) -> None:
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 720, 540, 100
    scene.render.image_settings.file_format = "PNG"
    scene.cycles.samples = 48
    # Light that diffracts twice is rare and bright: without a limit it leaves specks in the shadows at these samples.
    scene.cycles.sample_clamp_indirect = 0.5
    scene.cycles.use_denoising = False
    scene.cycles.shading_system = True
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"


def _link(ob: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(ob)
    return ob


def main(path: str) -> None:
    """Bake the snake preset, build the scene and save it as ``path``."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(Path(path).resolve()))
    bpy.ops.diffraction.make_preset(preset="snake")
    bpy.ops.diffraction.bake()
    build_scene()
    bpy.ops.diffraction.apply_material()
    bpy.ops.wm.save_mainfile()


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1] if "--" in sys.argv else "snake.blend")
