# SPDX-License-Identifier: GPL-3.0-or-later
"""Films and lacquer by operator and by panel, as the command line takes them."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from precompute.parameters import BakeParameters
from precompute.stack import parse_stack
from precompute.table.table import SpectralTable
from tests.support.blender.panels import shown, words

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def scene(tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    bpy.ops.diffraction.make_preset(preset="sinusoid", pixels=64, size_um=6.0)
    return bpy.context.scene.diffraction


def test_panel_and_operator_bake_what_python_bakes(scene, tmp_path):
    scene.detail, scene.substrate, scene.films, scene.lacquer = 0.3, "au", "1.46:250 (SiO2:10,TiO2:5)x3", "PMMA"
    assert bpy.ops.diffraction.bake() == {"FINISHED"}
    table = SpectralTable.load(bpy.path.abspath(scene.table_path))
    wanted = BakeParameters(stack=parse_stack("Au", ["1.46:250", "(SiO2:10,TiO2:5)x3"]), lacquer="PMMA")
    assert BakeParameters(stack=table.info["parameters"]["stack"]).stack == wanted.stack
    assert table.index == pytest.approx(wanted.index)
    assert "from the table" in words(shown("material"))
    assert '"IOR"' not in shown("material")
    assert bpy.ops.diffraction.bake(substrate="Ti", films="", lacquer="") == {"FINISHED"}
    again = SpectralTable.load(bpy.path.abspath(scene.table_path))
    assert again.info["stack"]["text"] == "Ti"
    assert again.index == 1.0
    assert scene.substrate == "Ti"  # what was used is shown


def test_swatch_is_the_mirror_of_the_stack(scene):
    scene.substrate, scene.films = "Au", ""
    red, green, blue = scene.stack_colour
    assert red > green > blue > 0.1
    scene.substrate = "unobtainium"
    assert np.array_equal(scene.stack_colour, (0, 0, 0))


@pytest.mark.parametrize(
    ("substrate", "films", "says"),
    [("", "SiO2:100", "substrate"), ("au", "SiO2:-5", "-5 nm"), ("unobtainium", "", "no material")],
)
def test_what_is_no_stack_ends_in_one_sentence(scene, substrate, films, says):
    with pytest.raises(RuntimeError, match=says):
        bpy.ops.diffraction.bake(substrate=substrate, films=films)
    assert not list(Path(bpy.path.abspath("//")).rglob("*.exr"))


def test_panel_plots_r_before_any_bake(scene):
    """The icon of the panel holds the core's picture; another film is another picture, nonsense is a sentence."""
    from diffraction_shader.addon.tables import stack_preview
    from diffraction_shader.precompute.evaluate.stack_plot import stack_plot
    from diffraction_shader.precompute.stack import parse_stack

    scene.substrate, scene.films, scene.lacquer = "Au", "1.46:250", ""
    text = shown("bake_stuff")
    assert "R from" in text
    _, said = stack_preview.plot("Au", "1.46:250", "")  # without a window Blender numbers no icons
    picture, least, largest = stack_plot(parse_stack("Au", ["1.46:250"]))
    kept = stack_preview._previews["Au | 1.46:250 | "]
    height, width, _ = picture.shape
    assert tuple(kept.image_size) == (width, height)
    pixels = np.array(kept.image_pixels_float[:]).reshape(height, width, 4)
    assert np.abs(pixels[..., :3] - picture).max() < 1 / 128
    assert said == f"R from {100 * least:.0f} (black) to {100 * largest:.0f} % (white)"
    other = stack_preview.plot("Au", "1.46:300", "")[1]
    again = np.array(stack_preview._previews["Au | 1.46:300 | "].image_pixels_float[:]).reshape(height, width, 4)
    assert other != said or np.abs(again - pixels).max() > 0.1
    scene.films = "1.46"
    assert "not understood" in shown("bake_stuff")
