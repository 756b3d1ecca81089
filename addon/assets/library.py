# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset library: a .blend with ready materials, their tables beside it, a catalogue and previews."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy

from ...precompute.presets import PRESETS
from . import dress, stage
from .looks import ASSETS, Asset

__all__ = ["ASSETS", "Asset", "build_assets", "make_material"]


#: Told of progress: what is being made, and the fraction done.
Progress = Callable[[str, float], object]


def build_assets(
    path: Path,
    only: tuple[str, ...] = (),
    detail: float = 1.0,
    samples: int = 32,
    implementation: str = "AUTO",
    side: int = stage.SIDE,
    progress: Progress = lambda name, fraction: None,
) -> list[bpy.types.Material]:
    """Bake, set up and save everything; the current file is replaced.

    Parameters
    ----------
    path
        The library's .blend; tables go to ``diffraction/`` beside it, the catalogue to its folder.
    only
        Names of materials, or of presets, which take those that are the preset as it is; empty takes all.
    detail
        Of the tables.
    samples
        Of the previews.
    implementation
        See ``diffraction.apply_material``.
    side
        Of the previews, pixels.
    progress
        Called before each material.
    """
    path = Path(path).resolve()
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)  # unlike factory settings it keeps add-ons
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    shapes = stage.build(scene)
    chosen = [asset for asset in ASSETS if not only or asset.name in only or (asset.is_plain and asset.preset in only)]
    catalogues = {name: _uuid(index) for index, name in enumerate(sorted({asset.catalogue for asset in ASSETS}), 1)}
    made = []
    for index, asset in enumerate(chosen):
        progress(asset.name, index / len(chosen))
        material = make_material(asset, shapes[asset.shape], detail, implementation)
        pixels = stage.picture(scene, shapes, asset, samples, side)
        preview = material.preview_ensure()
        preview.image_size = (side, side)
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
    """Bake an asset's structure and give an object its finished material."""
    state = bpy.context.scene.diffraction
    for name in ("substrate", "films", "lacquer"):
        state.property_unset(name)
    bpy.ops.diffraction.make_preset(preset=asset.preset, look=True, **asset.parameters)
    for name, value in asset.surface.items():
        setattr(state, name, value)
    bpy.ops.diffraction.bake(detail=detail)
    ob.data.materials.clear()
    for other in bpy.context.scene.objects:
        other.select_set(other == ob)
    bpy.context.view_layer.objects.active = ob
    bpy.ops.diffraction.apply_material(implementation=implementation)
    material = ob.active_material
    assert material is not None and material.node_tree is not None
    material.name = asset.name
    dress.dress(material, asset, ob, _period_m(asset))
    return material


def _period_m(asset: Asset) -> float:
    """Grating period of an asset's structure; 1 um where it has none."""
    values = {each.name: each.default for each in PRESETS[asset.preset].parameters} | asset.parameters
    return float(values.get("period_um", 1.0)) * 1e-6


def _write_catalogue(path: Path, catalogues: dict[str, str]) -> None:
    """The folders of the asset browser."""
    lines = ["# Catalogues of the diffraction materials", "", "VERSION 1", ""]
    lines += [f"{uuid}:Diffraction/{name}:Diffraction-{name}" for name, uuid in catalogues.items()]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _uuid(index: int) -> str:
    """Always the same, so that a library built anew keeps its catalogues."""
    return f"d1ff7ac7-0000-4000-8000-{index:012d}"
