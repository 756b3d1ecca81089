# SPDX-License-Identifier: GPL-3.0-or-later
"""What a finished material has beside its table: a print, a paint, a disc's parts, bare metal round a mark."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...precompute.files.atomic import atomic_path
from ...precompute.paint import save_paint
from .. import paths
from ..materials import material
from ..materials.node import paint_nodes
from ..materials.node_graph import Graph, Socket
from ..materials.scales import measure, wire
from .art import ART
from .looks import Asset

#: Scales along the body on which snakes are pictured.
SCALES = 26.0

#: Radii over that of the rim where a disc's clear hub, mirror band and data end (ECMA-130: data from 25 to 58 mm of 60,
#: with the lead-in before it).
HUB, BAND, DATA = 0.355, 0.385, 0.975


def dress(shaded: bpy.types.Material, asset: Asset, ob: bpy.types.Object, period_m: float) -> None:
    """Finish a material that shows its table.

    Parameters
    ----------
    shaded
        A material of ours with its node *Pigment*.
    asset
        What it is to be.
    ob
        What it lies on; scales fit its size.
    period_m
        Grating period of the structure.
    """
    tree: Any = shaded.node_tree
    pigment = tree.nodes.get("Pigment")
    if pigment is not None:
        pigment.inputs["Color"].default_value = (*asset.pigment, 1.0)
    if asset.species:
        node, _ = wire.add(shaded, asset.species, "OBJECT", ob, measure.longest_m(ob) / SCALES)
        node.inputs["Tail"].default_value = (1.0, 0.0, 0.0)  # as the body of the stage lies
    if asset.print_of == "DISC":
        _disc(tree, material.shader_node(shaded))
    if asset.art:
        paint, rgb = ART[asset.art](period_m)
        stem = asset.name.lower().replace(" ", "_").replace("-", "_")
        folder = paths.data_folder()
        folder.mkdir(parents=True, exist_ok=True)
        paint_nodes.wire(shaded, paint_nodes.load(save_paint(paint, folder / f"{stem}.paint.exr")))
        _print(tree, material.shader_node(shaded), asset, None if rgb is None else _image(rgb, folder / f"{stem}.png"))


def _image(rgb: np.ndarray, path: Path) -> bpy.types.Image:
    """A picture in the file: linear RGB is stored as sRGB, and packed."""
    from PIL import Image

    shown = np.where(rgb <= 0.0031308, 12.92 * rgb, 1.055 * np.clip(rgb, 1e-9, None) ** (1.0 / 2.4) - 0.055)
    with atomic_path(path) as temporary:
        Image.fromarray((np.clip(shown[::-1], 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)).save(temporary, "PNG")
    image = bpy.data.images.load(str(path), check_existing=True)
    image.reload()
    image.pack()
    image.filepath = paths.relative(path)
    return image


def _print(tree: Any, node: Any, asset: Asset, picture: bpy.types.Image | None) -> None:
    """Ink, silver or bare metal where no structure is, in a shader that gleams."""
    shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
    shader.name = shader.label = "Print"
    shader.location = (node.location.x - 320.0, node.location.y + 160.0)
    inputs = shader.inputs
    if picture is not None:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = picture
        texture.location = (shader.location.x - 300.0, shader.location.y)
        tree.links.new(texture.outputs["Color"], inputs["Base Color"])
        inputs["Roughness"].default_value = 0.25
    elif asset.art == "mark":
        inputs["Base Color"].default_value = (0.26, 0.255, 0.25, 1.0)
        inputs["Metallic"].default_value, inputs["Roughness"].default_value = 1.0, 0.5
    else:
        inputs["Base Color"].default_value = (*asset.pigment, 1.0)
    old = node.inputs["Base"].links[0].from_node if node.inputs["Base"].is_linked else None
    tree.links.new(shader.outputs["BSDF"], node.inputs["Base"])
    if old is not None and not old.outputs[0].is_linked:
        tree.nodes.remove(old)


def _disc(tree: Any, node: Any) -> None:
    """Data ring, mirror band and clear hub on the side that is read, a print on the other.

    Radii come from the bounding box, so that a disc of any size will do.
    """
    g = Graph(tree)
    place: Any = g.add("ShaderNodeTexCoord").outputs
    flat = g.vector("MULTIPLY", g.vector("SUBTRACT", place["Generated"], (0.5, 0.5, 0.0)), (2.0, 2.0, 0.0))
    radius = g.scalar("LENGTH", flat)
    back: Any = g.add("ShaderNodeNewGeometry").outputs["Backfacing"]
    front = g.difference(1.0, back)
    x, y, _ = g.split(flat)

    def ring(low: float, high: float) -> Socket:
        return g.product(g.math("GREATER_THAN", radius, low), g.math("LESS_THAN", radius, high))

    data, band = ring(BAND, DATA), ring(HUB, BAND)
    tree.links.new(g.product(data, front), node.inputs["Mask"])
    # The label: a white ground, a band of colour that a wave cuts, two hairlines.
    wave = g.fused(g.math("SINE", g.product(x, 5.0)), 0.12, 0.1)
    below = g.math("LESS_THAN", y, wave)
    hair = g.sum(ring(0.43, 0.437), ring(0.925, 0.931))
    label = g.mix(below, (0.72, 0.71, 0.68), (0.015, 0.09, 0.20))
    label = g.mix(g.product(below, g.math("GREATER_THAN", y, g.difference(wave, 0.10))), label, (0.65, 0.16, 0.02))
    label = g.mix(hair, label, (0.02, 0.02, 0.025))
    label = g.mix(ring(BAND + 0.02, DATA), (0.10, 0.105, 0.11), label)
    clear = g.mix(band, (0.055, 0.06, 0.065), (0.75, 0.76, 0.78))
    clear = g.mix(data, clear, (0.03, 0.03, 0.031))
    shader: Any = g.add("ShaderNodeBsdfPrincipled")
    shader.name = shader.label = "Disc"
    shader.hide = False
    g.put(shader.inputs["Base Color"], g.mix(front, label, clear))
    g.put(shader.inputs["Metallic"], g.product(band, front))
    g.put(shader.inputs["Roughness"], g.fused(front, -0.22, 0.32))
    # Of the data ring the table knows what is reflected.
    g.put(shader.inputs["Specular IOR Level"], g.fused(g.product(data, front), -0.5, 0.5))
    old = node.inputs["Base"].links[0].from_node
    tree.links.new(shader.outputs["BSDF"], node.inputs["Base"])
    tree.nodes.remove(old)
    for each in tree.nodes:
        if each.hide:
            each.location.x -= 2400.0
    shader.location = (node.location.x - 320.0, node.location.y)
