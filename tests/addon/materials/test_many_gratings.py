# SPDX-License-Identifier: GPL-3.0-or-later
"""One painted material of many gratings is that of as many materials with tables of their own, cell by cell."""

import bpy
import numpy as np
import pytest

from precompute.bake.baking import bake
from precompute.light.colour import luminance_row
from precompute.paint import Paint, save_paint
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan.heightfield import HeightField
from tests.support.blender import materials, scenes
from tests.support.blender.worlds import white_world

#: Of the table, metres.
SIGMA_S = 1.5e-6


def surface(s, q):
    field = make_preset("sinusoid", 24e-6, 300, period_um=1.4, amplitude_nm=60.0)
    return HeightField(q * field.heights, s * field.dx, s * field.dy)


def table_of(folder, name, s, q):
    path = folder / f"{name}.exr"
    bake(surface(s, q), BakeParameters(sigma_s_m=s * SIGMA_S, level="none", detail=0.6)).save(path)
    return path


def light():
    """A sky that brightens towards a place at 30 degrees, so that each grating sees some of it."""
    world = white_world()
    nodes, links = world.node_tree.nodes, world.node_tree.links
    last, split = nodes.new("ShaderNodeTexCoord").outputs["Generated"], nodes.new("ShaderNodeVectorMath")
    split.operation, split.inputs[1].default_value = "DOT_PRODUCT", (0.4, 0.3, 0.87)
    links.new(last, split.inputs[0])
    last = split.outputs["Value"]
    for operation, number in (("MAXIMUM", 0.0), ("POWER", 3.0), ("MULTIPLY", 10.0), ("ADD", 0.3)):
        node = nodes.new("ShaderNodeMath")
        node.operation, node.inputs[1].default_value = operation, number
        links.new(last, node.inputs[0])
        last = node.outputs[0]
    links.new(last, nodes["Background"].inputs["Strength"])
    scenes.add_camera((0.0, -0.05, 1.0), extent=2.0)


def cells(image, rows, cols):
    """Mean luminance of the middle of each cell."""
    height, width = image.shape[0] // rows, image.shape[1] // cols
    seen = image[: rows * height, : cols * width] @ luminance_row()
    blocks = seen.reshape(rows, height, cols, width)[:, height // 6 : -(height // 6), :, width // 6 : -(width // 6)]
    return blocks.mean((1, 3))


@pytest.mark.parametrize(
    ("rows", "cols", "side", "pixels", "samples", "conserve"),
    [
        (2, 2, 64, 32, 256, True),
        pytest.param(5, 10, 1024, 200, 128, False, marks=pytest.mark.slow),
        pytest.param(5, 10, 1024, 200, 128, True, marks=pytest.mark.slow),
    ],
)
def test_a_map_of_gratings_is_as_many_materials(blender, tmp_path, rows, cols, side, pixels, samples, conserve):
    """To 2 percent."""
    random = np.random.default_rng(6)
    shape = (rows, cols)
    scale, depth, rotation = (
        random.uniform(low, high, shape) for low, high in ((0.5, 1.0), (0.5, 1.0), (0.0, 2.0 * np.pi))
    )
    light()
    row, col = (np.arange(side) * rows // side)[:, None], (np.arange(side) * cols // side)[None]
    maps = [each[row, col] for each in (scale, depth, rotation, np.ones(shape))]
    plane = scenes.add_plane(half=1.0)
    table = table_of(tmp_path, "one", 1.0, 1.0)
    made = materials.diffracting(plane, table, fresnel="NONE", environment=1, conserve_energy=conserve)
    from diffraction_shader.addon.materials.node import paint_nodes

    paint_nodes.wire(made, paint_nodes.load(save_paint(Paint(*maps), tmp_path / "paint.exr")))
    painted = cells(scenes.render(pixels, samples), rows, cols)

    bpy.data.objects.remove(plane)
    for r, c in np.ndindex(shape):
        tile = scenes.add_plane(f"tile {r} {c}", half=1.0)
        tile.scale = (1.0 / cols, 1.0 / rows, 1.0)
        tile.location = ((2 * c + 1) / cols - 1.0, (2 * r + 1) / rows - 1.0, 0.0)
        path = table_of(tmp_path, f"t {r} {c}", scale[r, c], depth[r, c])
        own = materials.diffracting(tile, path, fresnel="NONE", environment=1, conserve_energy=conserve)
        own.node_tree.nodes["Diffraction"].inputs["Rotation"].default_value = rotation[r, c]
    separate = cells(scenes.render(pixels, samples), rows, cols)
    lit = separate > 0.02 * separate.max()
    assert lit.mean() > 0.9
    error = np.abs(painted - separate)[lit] / separate[lit]
    worst, mean = 100 * error.max(), 100 * error.mean()
    print(f"{rows * cols} gratings, conserving {conserve}: worst cell {worst:.2f} %, mean {mean:.2f} %")
    assert error.max() < 0.02
