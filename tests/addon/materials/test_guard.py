# SPDX-License-Identifier: GPL-3.0-or-later
"""Whatever lets a renderer see another image than the one that was baked ends in the pigment alone."""

import bpy
import numpy as np
import pytest

from precompute.table import importance
from precompute.table.layout import GUARD, GUARD_TOLERANCE
from tests.support.blender import extension, materials, scenes, tables, worlds

#: A pigment that is told from black.
PIGMENT = (0.05, 0.1, 0.2, 1.0)


@pytest.fixture
def ball(blender, tmp_path):
    """A sphere with a table of 500 texels, under a sun and a dim world."""
    path = tmp_path / "t.exr"
    tables.make_table(path, tables.lobes)
    sphere = scenes.add_sphere(segments=32, rings=16)
    scenes.add_sun((0.3, 0.1, 0.9))
    scenes.add_camera()
    worlds.white_world((0.1, 0.1, 0.1, 1))
    return sphere, path


def diffracting(ball, implementation, environment=1):
    sphere, path = ball
    made = materials.diffracting(sphere, path, implementation, pigment=PIGMENT, fresnel="NONE", environment=environment)
    return made.node_tree.nodes["Diffraction"]


def pigment_alone(node):
    node.inputs["Mask"].default_value = 0.0
    alone = scenes.render(24, samples=4)
    node.inputs["Mask"].default_value = 1.0
    return alone


def atlas(node):
    return node.node_tree["diffraction_atlas"]


def set_limit(node, tmp_path):
    bpy.context.scene.render.use_simplify = True
    bpy.context.scene.cycles.texture_limit_render = "256"


def set_resolution(node, tmp_path):
    bpy.context.scene.render.use_simplify = True
    if not hasattr(bpy.context.scene.cycles, "texture_resolution_render"):
        pytest.skip("this Blender has no Texture Resolution")
    bpy.context.scene.cycles.texture_resolution_render = 0.5


def resize(node, tmp_path):
    image = atlas(node)
    image.scale(image.size[0] * 3 // 4, image.size[1] * 3 // 4)
    rewrite(image, tmp_path / "resized.exr")


def take(image, path):
    """The image and the shader then read another file."""
    extension.load()
    from diffraction_shader.addon.materials import travel

    if image.packed_file is not None:
        image.unpack(method="REMOVE")
    image.filepath = str(path)
    image.reload()
    travel.sync_all()


def rewrite(image, path):
    """Save what Blender holds of an image under another name, and take that."""
    image.file_format = "OPEN_EXR"
    image.save(filepath=str(path))
    take(image, path)


def eight_bit(node, tmp_path):
    """As a packed table that is saved as a PNG."""
    image = atlas(node)
    small = bpy.data.images.new("eight", *image.size)
    small.colorspace_settings.name = "Non-Color"
    small.pixels.foreach_set(np.clip(np.array(image.pixels[:], np.float32), 0.0, 1.0))
    save(small, tmp_path / "eight.png")
    take(image, tmp_path / "eight.png")


def another_picture(node, tmp_path):
    made = bpy.data.images.new("grid", 64, 64)
    made.generated_type = "COLOR_GRID"
    save(made, tmp_path / "grid.png")
    take(atlas(node), tmp_path / "grid.png")


def save(image, path):
    image.file_format = "PNG"
    image.save(filepath=str(path))
    assert path.read_bytes()[1:4] == b"PNG"


def colour_space(node, tmp_path):
    atlas(node).colorspace_settings.name = "sRGB"


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
@pytest.mark.parametrize("change", [set_limit, set_resolution, resize, eight_bit, another_picture])
def test_another_image_shows_the_pigment_alone(ball, tmp_path, change, implementation):
    node = diffracting(ball, implementation)
    alone, whole = pigment_alone(node), scenes.render(24, samples=4)
    assert whole.max() > 2 * alone.max()
    change(node, tmp_path)
    if change is set_limit and implementation == "OSL" and bpy.app.version < (5, 2, 0):
        alone = whole  # OSL of Blender before 5.2 reads its files by itself
    np.testing.assert_allclose(scenes.render(24, samples=4), alone, rtol=0.02, atol=1e-3)


def test_a_colour_space_set_by_hand_shows_the_pigment_alone(ball, tmp_path):
    """OSL reads the file by its name, whatever Blender's image says."""
    node = diffracting(ball, "NODES")
    alone = pigment_alone(node)
    colour_space(node, tmp_path)
    np.testing.assert_allclose(scenes.render(24, samples=4), alone, rtol=0.02, atol=1e-3)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_directions_of_another_image_are_not_drawn(ball, tmp_path, implementation):
    """The lamps are diffracted, the environment is not: as with Environment 0."""
    node = diffracting(ball, implementation)
    whole = scenes.render(24, samples=64)
    node.inputs["Environment"].default_value = 0
    lamps = scenes.render(24, samples=64)
    node.inputs["Environment"].default_value = 1

    def brighter(image):  # of most pixels: the mean is that of the lamp's mirror image
        return float(np.median((image.mean(-1) / lamps.mean(-1))[lamps.mean(-1) > 1.01 * lamps.min()]))

    assert brighter(whole) > 1.05
    image = node.node_tree["diffraction_importance"]
    image.scale(image.size[0] // 2, image.size[1] // 2)
    rewrite(image, tmp_path / "directions.exr")
    assert brighter(scenes.render(24, samples=64)) == pytest.approx(1.0, abs=0.01)


def test_both_images_hold_the_guard(ball):
    from precompute.table.table import SpectralTable

    table = SpectralTable.load(ball[1])
    layout = table.layout
    assert tuple(table.atlas[layout.guard_y, layout.guard_x]) == GUARD
    image = importance.importance(table).image()
    assert tuple(image[importance.GUARD_Y, importance.GUARD_X]) == GUARD
    around = image[importance.HEIGHT - 2 * importance.GUARD_X - 1 :, : 2 * importance.GUARD_X + 1].copy()
    around[importance.GUARD_X, importance.GUARD_X] = 0.0
    assert not around.any()


def test_a_lookup_of_the_guard_tells_small_changes():
    """In 8 bits, in sRGB, one part in fifty smaller: each is further away than the tolerance."""
    high, middle, low = GUARD
    for seen in ((1.0, middle, 0.0), (high, 0.735, low), (high, 0.214, low), (0.98 * high, 0.98 * middle, low)):
        assert np.linalg.norm(np.subtract(seen, GUARD)) > 0.8 * GUARD_TOLERANCE
