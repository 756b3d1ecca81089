# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset library: a .blend with ready materials, their tables beside it, a catalogue and previews."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import bpy

from ...precompute.presets import look_of
from . import stage


@dataclass(frozen=True)
class Asset:
    """One material of the library; surface and bake are those that suit its preset.

    Parameters
    ----------
    name, catalogue, description
        As the asset browser shows them.
    preset
        Structure, see ``precompute.presets``.
    parameters
        Of the preset, in the units of their names.
    pigment
        Linear RGB under the diffraction.
    """

    name: str
    catalogue: str
    description: str
    preset: str
    parameters: dict = field(default_factory=dict)
    pigment: tuple[float, float, float] = (0.012, 0.010, 0.009)


_GREY = (0.03, 0.03, 0.031)

ASSETS = (
    Asset("Xenopeltis Skin", "Animals", "Sunbeam snake: steep saw-tooth scales on black skin", "snake"),
    Asset("Elaphe Skin", "Animals", "Corn snake: shallow columns of micro-fibrils", "elaphe"),
    Asset("Morpho", "Animals", "Ridges of a blue butterfly's scale over a stack of lamellae", "morpho"),
    Asset("Jewel Beetle", "Animals", "Layers of melanin and chitin: green, blue at the rim", "jewel_beetle"),
    Asset("CD", "Discs", "Pits 1.6 um apart; put the object's z axis through the hole", "cd", {}, _GREY),
    Asset("DVD", "Discs", "Pits 0.74 um apart", "dvd", {}, _GREY),
    Asset("Blu-ray", "Discs", "Pits 0.32 um apart: hardly any colour but at grazing light", "bluray", {}, _GREY),
    Asset("Blazed Grating 400/mm", "Gratings", "Ruled plate that throws its light to one side", "blazed"),
    Asset("Sinusoidal Grating", "Gratings", "Holographic grating of 2 um", "sinusoid"),
    Asset("Holographic Foil", "Foils", "Crossed gratings of gift wrap and bank notes", "foil", {}, _GREY),
    Asset("Brushed Metal", "Foils", "Random grooves along y", "brushed_metal", {}, _GREY),
    Asset("Random Bumps", "Foils", "A field of random bumps after Stam", "stam_bumps"),
    Asset("Gold Foil", "Foils", "Crossed gratings in gold", "gold_foil"),
    Asset("Lacquered Holographic Foil", "Foils", "Crossed gratings under a clear varnish", "lacquered_foil"),
    Asset("Oil on a Brushed Plate", "Foils", "A film of oil on brushed steel", "oily_plate", {}, _GREY),
    Asset("Copper Grating 600/mm", "Gratings", "Sinusoidal grating in copper", "copper_plate"),
    Asset("Anodised Titanium", "Gratings", "Ripple of laser pulses under an oxide film", "titanium_ripple"),
)

#: Told of progress: what is being made, and the fraction done.
Progress = Callable[[str, float], object]


def build_assets(
    path: Path,
    only: tuple[str, ...] = (),
    detail: float = 1.0,
    samples: int = 32,
    implementation: str = "AUTO",
    progress: Progress = lambda name, fraction: None,
) -> list[bpy.types.Material]:
    """Bake, set up and save everything; the current file is replaced.

    Parameters
    ----------
    path
        The library's .blend; tables go to ``diffraction/`` beside it, the catalogue to its folder.
    only
        Names of presets; empty takes all.
    detail
        Of the tables.
    samples
        Of the previews.
    implementation
        See ``diffraction.apply_material``.
    progress
        Called before each material.
    """
    path = Path(path).resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)  # unlike factory settings it keeps add-ons
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    ball, disc = stage.build(scene)
    chosen = [asset for asset in ASSETS if not only or asset.preset in only]
    catalogues = {name: _uuid(index) for index, name in enumerate(sorted({asset.catalogue for asset in ASSETS}), 1)}
    made = []
    for index, asset in enumerate(chosen):
        progress(asset.name, index / len(chosen))
        look = look_of(asset.preset)
        flat = look.orientation == "RADIAL"
        material = make_material(asset, disc if flat else ball, detail, implementation)
        pixels = stage.picture(scene, material, (ball, disc), flat, look.is_bright, samples)
        preview = material.preview_ensure()
        preview.image_size = (stage.SIDE, stage.SIDE)
        preview.image_pixels_float.foreach_set(pixels)
        material.asset_mark()
        data = material.asset_data
        assert data is not None
        data.catalog_id = catalogues[asset.catalogue]
        data.description, data.author = asset.description, "Diffraction Shader"
        for tag in ("diffraction", asset.catalogue.lower(), asset.preset):
            data.tags.new(tag, skip_if_exists=True)
        material.use_fake_user = True
        made.append(material)
    _write_catalogue(path.parent / "blender_assets.cats.txt", catalogues)
    before = bpy.context.preferences.filepaths.save_version
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_mainfile()
    bpy.context.preferences.filepaths.save_version = before
    progress("done", 1.0)
    return made


def make_material(asset: Asset, ob: bpy.types.Object, detail: float, implementation: str) -> bpy.types.Material:
    """Bake an asset's structure and give an object its material."""
    bpy.ops.diffraction.make_preset(preset=asset.preset, look=True, **asset.parameters)
    bpy.ops.diffraction.bake(detail=detail)
    ob.data.materials.clear()
    for other in bpy.context.scene.objects:
        other.select_set(other == ob)
    bpy.context.view_layer.objects.active = ob
    bpy.ops.diffraction.apply_material(implementation=implementation)
    material = ob.active_material
    assert material is not None and material.node_tree is not None
    material.name = asset.name
    pigment = material.node_tree.nodes.get("Pigment")
    if pigment is not None:
        pigment.inputs["Color"].default_value = (*asset.pigment, 1.0)
    return material


def _write_catalogue(path: Path, catalogues: dict[str, str]) -> None:
    """The folders of the asset browser."""
    lines = ["# Catalogues of the diffraction materials", "", "VERSION 1", ""]
    lines += [f"{uuid}:Diffraction/{name}:Diffraction-{name}" for name, uuid in catalogues.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _uuid(index: int) -> str:
    """Always the same, so that a library built anew keeps its catalogues."""
    return f"d1ff7ac7-0000-4000-8000-{index:012d}"
