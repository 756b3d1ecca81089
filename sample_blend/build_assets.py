# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset library: a .blend with ready materials, their tables beside it, a catalogue and previews.

``blender -b -P sample_blend/build_assets.py -- assets/materials.blend`` (the extension enabled) bakes each structure,
sets its material up and renders its preview. Give Blender the folder under *Preferences > File Paths > Asset
Libraries*; a material dragged from it finds its table wherever the library lies.
"""

from __future__ import annotations

import math
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector


@dataclass(frozen=True)
class Asset:
    """One material of the library.

    Parameters
    ----------
    name, catalogue, description
        As the asset browser shows them.
    preset
        Structure, see ``precompute.presets``.
    parameters
        Of the preset, in the units of their names.
    surface
        Options of ``diffraction.apply_material``.
    pigment
        Linear RGB under the diffraction.
    """

    name: str
    catalogue: str
    description: str
    preset: str
    parameters: dict = field(default_factory=dict)
    surface: dict = field(default_factory=dict)
    pigment: tuple[float, float, float] = (0.012, 0.010, 0.009)


_METAL = {"fresnel": "CONDUCTOR"}
_DISC = {"fresnel": "CONDUCTOR", "orientation": "RADIAL"}
_GREY = (0.03, 0.03, 0.031)

ASSETS = (
    Asset("Xenopeltis Skin", "Animals", "Sunbeam snake: steep saw-tooth scales on black skin", "snake"),
    Asset("Elaphe Skin", "Animals", "Corn snake: shallow columns of micro-fibrils", "elaphe"),
    Asset("Morpho Ridges", "Animals", "Ridges of a butterfly's scale, diffraction only", "morpho"),
    Asset("CD", "Discs", "Pits 1.6 um apart; put the object's z axis through the hole", "cd", {}, _DISC, _GREY),
    Asset("DVD", "Discs", "Pits 0.74 um apart", "dvd", {}, _DISC, _GREY),
    Asset("Blu-ray", "Discs", "Pits 0.32 um apart: hardly any colour but at grazing light", "bluray", {}, _DISC, _GREY),
    Asset("Blazed Grating 400/mm", "Gratings", "Ruled plate that throws its light to one side", "blazed", {}, _METAL),
    Asset("Sinusoidal Grating", "Gratings", "Holographic grating of 2 um", "sinusoid", {}, _METAL),
    Asset("Holographic Foil", "Foils", "Crossed gratings of gift wrap and bank notes", "foil", {}, _METAL, _GREY),
    Asset("Brushed Metal", "Foils", "Random grooves along y", "brushed_metal", {}, _METAL, _GREY),
    Asset("Random Bumps", "Foils", "A field of random bumps after Stam", "stam_bumps", {}, _METAL),
)

#: Side of the previews in pixels.
PREVIEW_SIDE = 128


def build_assets(
    path: Path, only: tuple[str, ...] = (), detail: float = 1.0, samples: int = 32, implementation: str = "OSL"
) -> list[bpy.types.Material]:
    """Bake, set up and save everything; the current file is replaced.

    Parameters
    ----------
    path
        The library's .blend; tables go to ``diffraction/`` beside it, the catalogue to its folder.
    only
        Names of presets; empty takes all that this release has.
    detail
        Of the tables.
    samples
        Of the previews.
    implementation
        ``OSL`` or ``NODES``, see ``diffraction.apply_material``.
    """
    path = Path(path).resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    ball, disc = _stage(scene)
    known = {item.identifier for item in scene.diffraction.bl_rna.properties["preset"].enum_items}
    chosen = [asset for asset in ASSETS if asset.preset in known and (not only or asset.preset in only)]
    catalogues = {name: _uuid(index) for index, name in enumerate(sorted({asset.catalogue for asset in ASSETS}), 1)}
    made = []
    for asset in chosen:
        material = _material(asset, disc if "orientation" in asset.surface else ball, detail, implementation)
        _render_preview(scene, material, (ball, disc), asset, samples)
        material.asset_mark()
        data = material.asset_data
        data.catalog_id = catalogues[asset.catalogue]
        data.description, data.author = asset.description, "Diffraction Shader"
        for tag in ("diffraction", asset.catalogue.lower(), asset.preset):
            data.tags.new(tag, skip_if_exists=True)
        material.use_fake_user = True
        made.append(material)
    _write_catalogue(path.parent / "blender_assets.cats.txt", catalogues)
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_mainfile()
    return made


def _material(asset: Asset, ob: bpy.types.Object, detail: float, implementation: str) -> bpy.types.Material:
    bpy.ops.diffraction.make_preset(preset=asset.preset, **asset.parameters)
    bpy.ops.diffraction.bake(detail=detail, level="none")
    ob.data.materials.clear()
    for other in bpy.context.scene.objects:
        other.select_set(other == ob)
    bpy.context.view_layer.objects.active = ob
    bpy.ops.diffraction.apply_material(implementation=implementation, **{"fresnel": "DIELECTRIC", **asset.surface})
    material = ob.active_material
    material.name = asset.name
    pigment = material.node_tree.nodes.get("Pigment")
    if pigment is not None:
        pigment.inputs["Color"].default_value = (*asset.pigment, 1.0)
    return material


#: Suns of the ball: direction, and irradiance on skin. Metal reflects twenty times as much.
_SUNS = {"Sun": ((-0.35, -0.55, 0.75), 22.0), "Window": ((0.75, -0.3, 0.45), 9.0)}


def _stage(scene: bpy.types.Scene) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A ball under two suns and a disc under a bulb near the camera, where a disc shows its spokes, and a dim sky."""
    ball = _link(scene, "Ball", _ball())
    disc = _link(scene, "Disc", _disc())
    disc.rotation_euler = (math.radians(62.0), 0.0, math.radians(12.0))
    for name, (direction, _) in _SUNS.items():
        light = bpy.data.lights.new(name, "SUN")
        light.angle = math.radians(1.0)
        lamp = _link(scene, name, light)
        lamp.rotation_euler = Vector(direction).to_track_quat("Z", "Y").to_euler()
    bulb = bpy.data.lights.new("Bulb", "POINT")
    bulb.energy, bulb.shadow_soft_size = 200.0, 0.04
    _link(scene, "Bulb", bulb).location = (0.35, -2.9, 1.2)
    camera = bpy.data.cameras.new("Camera")
    camera.lens = 36.0 * 3.6 / 2.25
    scene.camera = _link(scene, "Camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0.0, -3.6, 0.0), (math.radians(90.0), 0.0, 0.0)
    world = bpy.data.worlds.new("Dim Sky")
    if world.node_tree is None:  # before Blender 5.0
        world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.05, 0.06, 0.08, 1.0)
    scene.world = world
    scene.view_settings.view_transform = "Standard"
    bpy.context.view_layer.update()
    return ball, disc


def _ball(segments: int = 128, rings: int = 64) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Ball")
    lon = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    lat = np.linspace(-0.5 * np.pi + 0.02, 0.5 * np.pi - 0.02, rings + 1)
    lon, lat = np.meshgrid(lon, lat)
    points = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], -1).reshape(-1, 3)
    return _grid(mesh, points, np.stack([lon, lat], -1).reshape(-1, 2), segments + 1, rings + 1)


def _disc(segments: int = 192, rings: int = 4) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new("Disc")
    # From the rim inwards, so that the faces look up.
    lon, radius = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, segments + 1), np.linspace(1.0, 0.2, rings + 1))
    points = np.stack([radius * np.cos(lon), radius * np.sin(lon), np.zeros_like(lon)], -1).reshape(-1, 3)
    return _grid(mesh, points, np.stack([radius, lon], -1).reshape(-1, 2), segments + 1, rings + 1)


def _grid(mesh: bpy.types.Mesh, points: np.ndarray, uv: np.ndarray, columns: int, rows: int) -> bpy.types.Mesh:
    index = np.arange(columns * rows).reshape(rows, columns)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    mesh.from_pydata(points.tolist(), [], quads.tolist())
    mesh.uv_layers.new(name="UVMap").uv.foreach_set("vector", uv[quads.ravel()].astype(np.float32).ravel())
    mesh.shade_smooth()
    return mesh


def _render_preview(
    scene: bpy.types.Scene, material: bpy.types.Material, objects: tuple, asset: Asset, samples: int
) -> None:
    """Render the material on its object into its preview: a background Blender makes none by itself."""
    for ob in objects:
        ob.hide_render = ob.active_material != material
    flat, metal = "orientation" in asset.surface, asset.surface.get("fresnel") == "CONDUCTOR"
    for name, (_, strength) in _SUNS.items():
        scene.objects[name].hide_render = flat
        scene.objects[name].data.energy = strength * (0.06 if metal else 1.0)
    scene.objects["Bulb"].hide_render = not flat
    bpy.context.view_layer.update()
    render = scene.render
    render.resolution_x = render.resolution_y = PREVIEW_SIDE
    render.resolution_percentage = 100
    render.film_transparent = True
    render.image_settings.file_format, render.image_settings.color_mode = "PNG", "RGBA"
    scene.cycles.samples = samples
    with tempfile.TemporaryDirectory() as folder:
        render.filepath = str(Path(folder) / "preview.png")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath)
        pixels = np.empty(PREVIEW_SIDE * PREVIEW_SIDE * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    preview = material.preview_ensure()
    preview.image_size = (PREVIEW_SIDE, PREVIEW_SIDE)
    preview.image_pixels_float.foreach_set(pixels)


def _write_catalogue(path: Path, catalogues: dict[str, str]) -> None:
    """The folders of the asset browser."""
    lines = ["# Catalogues of the diffraction materials", "", "VERSION 1", ""]
    lines += [f"{uuid}:Diffraction/{name}:Diffraction-{name}" for name, uuid in catalogues.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _uuid(index: int) -> str:
    """Always the same, so that a library built anew keeps its catalogues."""
    return f"d1ff7ac7-0000-4000-8000-{index:012d}"


def _link(scene: bpy.types.Scene, name: str, data: bpy.types.ID) -> bpy.types.Object:
    ob = bpy.data.objects.new(name, data)
    scene.collection.objects.link(ob)
    return ob


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    build_assets(Path(arguments[0] if arguments else "assets/materials.blend"))
