# SPDX-License-Identifier: GPL-3.0-or-later
"""The finished materials: their table is whole, what they are painted with makes sense, and each renders unwarned."""

import re

import bpy
import numpy as np
import pytest

pytestmark = pytest.mark.usefixtures("blender")

#: Rendered in every run; the rest is slow.
FAST = (("CD", "OSL"), ("Corn Snake", "NODES"))

#: Lines of Blender about itself, not about what it renders: devices that are not there, and what its windowless context
#: of Mesa's software renderer says.
HARMLESS = re.compile(
    r"CUEW|HIP|oneAPI|Metal|OptiX|ALSA|icon ID|Fra:"
    r"|^EGL Error \(0x3009\): EGL_BAD_MATCH: Arguments are inconsistent \(for example, a valid context requires"
    r" buffers not supplied by a valid surface\)\.$",
    re.IGNORECASE,
)


@pytest.fixture(scope="module")
def wing():
    from tests.support.blender import extension

    extension.load()
    from diffraction_shader.addon.assets import art, library, looks, stage

    return type("Wing", (), {"art": art, "library": library, "looks": looks, "stage": stage})


def names():
    import ast

    from tests.support.blender import extension

    tree = ast.parse((extension.ROOT / "addon" / "assets" / "looks.py").read_text(encoding="utf-8"))
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Asset"]
    return [call.args[0].value for call in calls]


def test_the_table_is_whole(wing):
    from diffraction_shader.addon.materials.scales.species import SPECIES
    from diffraction_shader.precompute.presets import PRESETS

    assets = wing.looks.ASSETS
    assert [asset.name for asset in assets] == names()
    assert len(assets) >= 16 and len({asset.name for asset in assets}) == len(assets)
    for asset in assets:
        preset = PRESETS[asset.preset]
        assert set(asset.parameters) <= {parameter.name for parameter in preset.parameters}
        assert not asset.art or asset.art in wing.art.ART
        assert not asset.species or SPECIES[asset.species].preset == asset.preset
        assert asset.shape in wing.stage._SHAPES and len(asset.description) < 90
        assert all(hasattr(bpy.context.scene.diffraction, name) for name in asset.surface)


def test_what_mirrors_is_seen_by_its_orders(wing):
    """A dim room, a tube for its stripes; skin has neither, and pictures share what is hidden and strong."""
    from diffraction_shader.addon.materials.twin.lamps import EEVEE_LAMPS_MAX

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    shapes = wing.stage.build(scene)
    lamps = [ob for ob in scene.objects if ob.type == "LIGHT"]
    assert len(lamps) <= EEVEE_LAMPS_MAX
    sky = scene.world.node_tree.nodes["Background"].inputs["Strength"]
    seen = {}
    for asset in wing.looks.ASSETS:
        if asset.name in ("Gold Grating 600/mm", "CD", "Trading Card", "Corn Snake"):
            wing.stage.picture(scene, shapes, asset, 1, 8)
            seen[asset.name] = {ob.name for ob in lamps if not ob.hide_render}, sky.default_value
            assert [name for name, ob in shapes.items() if not ob.hide_render] == [asset.shape]
    assert {name: names for name, (names, _) in seen.items()} == {
        "Gold Grating 600/mm": {"Sun", "Window", "Tube"},
        "CD": {"Bulb"},
        "Trading Card": {"Bulb", "Tube"},
        "Corn Snake": {"Sun", "Window"},
    }
    assert all(strength < 1.0 for name, (_, strength) in seen.items() if name != "Corn Snake")


@pytest.mark.parametrize("name", ["brush", "glitter", "card", "sticker", "mark"])
def test_art_is_a_paint_that_one_table_holds(wing, name):
    """No period above the table's, structure on a part of the picture, several directions, ink beside it."""
    paint, rgb = wing.art.ART[name](1e-6)
    assert max(paint.most) <= 1.0
    there = paint.mask > 0
    assert there.any() and (name in ("brush", "glitter") or 0.1 < there.mean() < 0.9)
    assert len(np.unique(np.round(paint.rotation[there], 2))) > 10
    if rgb is not None:
        assert rgb.shape == (*paint.shape, 3) and rgb.min() >= 0.0 and rgb.max() < 0.9
    if name == "card":
        assert paint.shape[1] / paint.shape[0] == pytest.approx(63 / 88, rel=0.01)


def picture(wing, tmp_path, name, implementation, engine, side):
    """A look on its shape, small, and what Blender said meanwhile is left to the caller."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "look.blend"))
    shapes = wing.stage.build(scene)
    asset = next(each for each in wing.looks.ASSETS if each.name == name)
    wing.library.make_material(asset, shapes[asset.shape], 0.25, implementation)
    scene.render.engine = engine
    if engine != "CYCLES":
        scene.eevee.taa_render_samples = 1
    pixels = wing.stage.picture(scene, shapes, asset, 4, side)
    return pixels.reshape(side, side, 4)


def unwarned(text):
    lines = [line for line in text.splitlines() if re.search(r"warn|error", line, re.IGNORECASE)]
    return [line for line in lines if not HARMLESS.search(line)]


def assert_shows(pixels):
    """A lit thing before nothing."""
    assert np.isfinite(pixels).all()
    there = pixels[..., 3] > 0.5
    assert 0.2 < there.mean() < 0.95
    seen = pixels[there][:, :3]
    assert seen.max() > 0.2 and seen.mean() > 0.005 and np.ptp(seen.mean(1)) > 0.05
    magenta = (seen[:, 0] > 0.9) & (seen[:, 2] > 0.9) & (seen[:, 1] < 0.1)
    assert magenta.mean() < 0.01  # Blender's colour of missing images


@pytest.mark.parametrize(
    ("name", "implementation"),
    [
        pytest.param(name, kind, marks=() if (name, kind) in FAST else pytest.mark.slow)
        for name in names()
        for kind in ("OSL", "NODES")
    ],
)
def test_renders_in_cycles_without_a_warning(wing, tmp_path, capfd, name, implementation):
    pixels = picture(wing, tmp_path, name, implementation, "CYCLES", 40)
    assert unwarned("".join(capfd.readouterr())) == []
    assert_shows(pixels)


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_renders_in_eevee_without_a_warning(wing, tmp_path, capfd, name):
    from diffraction_shader.addon.versions import EEVEE

    pixels = picture(wing, tmp_path, name, "NODES", EEVEE, 40)
    assert unwarned("".join(capfd.readouterr())) == []
    assert_shows(pixels)
