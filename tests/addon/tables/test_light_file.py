# SPDX-License-Identifier: GPL-3.0-or-later
"""An illuminant from a file in the panel: baked, stale when the file changes, baked again when it is gone."""

import json

import bpy
import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from precompute.light.illuminant import illuminant_of, read_spectrum
from precompute.table.table import SpectralTable
from tests.support.blender.panels import plane_with_material, preset, shown, words
from tests.support.light_files import cie, light_file


@pytest.fixture
def project(blender, tmp_path):
    """A saved .blend with a grating, and a lamp's file beside it."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    preset()
    light_file(tmp_path / "lamp.csv", *cie("FL11"))
    return tmp_path


def bake(**options):
    assert bpy.ops.diffraction.bake(detail=0.25, illuminant="FILE", **options) == {"FINISHED"}
    return bpy.context.scene.diffraction


def test_file_is_baked_and_its_change_is_told(project):
    state = bake(illuminant_file="//lamp.csv")
    table = SpectralTable.load(project / "diffraction" / "sinusoid.exr")
    light = read_spectrum(project / "lamp.csv")
    assert illuminant_of(table.info["colour"]["illuminant"]) == light
    assert (state.illuminant, state.illuminant_file) == ("FILE", "//lamp.csv")
    assert "Changed since" not in words(shown("bake"))

    plane = plane_with_material()
    matrix = [tuple(bpy.context.scene[f"diffraction_to_{c}"]) for c in ("red", "green", "blue")]
    assert np.allclose(matrix, xyz_to_rgb_matrix("Linear Rec.709", "D65"), atol=1e-6)

    from diffraction_shader.addon.viewport import looks

    for normalisation in ("ABSOLUTE", "RELATIVE"):  # the viewport reads the light from the sidecar
        view = looks.View(normalisation=normalisation)
        seen = looks.surface(plane.active_material, table.layout, table.info, view)
        assert np.allclose(seen.to_rgb, matrix, atol=1e-6)
        assert np.isfinite(seen.brightness) and seen.brightness > 0.0

    (project / "copy.csv").write_bytes((project / "lamp.csv").read_bytes())
    state.illuminant_file = "//copy.csv"
    assert "Changed since" not in words(shown("bake"))  # values count, not names
    state.illuminant_file = "//lamp.csv"
    nm, power = cie("FL11")
    light_file(project / "lamp.csv", nm, power + 3.0)
    assert "Changed since the bake: Values of the Light File." in words(shown("bake"))
    state.illuminant = "D65"
    assert "Changed since the bake: Illuminant." in words(shown("bake"))


def test_without_its_file_a_table_is_baked_again_from_the_kept_values(project):
    state = bake(illuminant_file="//lamp.csv")
    plane = plane_with_material()
    path = project / "diffraction" / "sinusoid.exr"
    before = {each.suffix: each.read_bytes() for each in (path, path.with_suffix(".json"))}
    (project / "lamp.csv").unlink()
    assert "The file is gone; the values that were baked stand for it" in words(shown("bake_advanced"))
    assert "Changed since" not in words(shown("bake"))
    path.unlink()
    assert bpy.ops.diffraction.rebake(scope="BROKEN") == {"FINISHED"}
    assert path.read_bytes() == before[".exr"]
    path.unlink()
    assert bpy.ops.diffraction.bake() == {"FINISHED"}  # from the panel
    assert path.read_bytes() == before[".exr"]
    # In another file: the recipe of the material brings all of it back.
    state.illuminant, state.illuminant_file, state.illuminant_data = "D65", "", ""
    bpy.context.view_layer.objects.active = plane
    assert bpy.ops.diffraction.use_material_scan() == {"FINISHED"}
    assert (state.illuminant, state.illuminant_file) == ("FILE", "//lamp.csv")
    assert bpy.ops.diffraction.bake() == {"FINISHED"}
    assert path.with_suffix(".json").read_bytes() == before[".json"]
    # A changed file does not change what `Bake Again` makes of a material's recipe.
    nm, power = cie("A")
    light_file(project / "lamp.csv", nm, power)
    path.unlink()
    assert bpy.ops.diffraction.rebake(scope="BROKEN") == {"FINISHED"}
    assert path.with_suffix(".json").read_bytes() == before[".json"]


def test_refusals(project):
    (project / "bad.csv").write_text("400,1\n500,1\n")
    state = bpy.context.scene.diffraction
    state.illuminant, state.illuminant_file = "FILE", "//bad.csv"
    assert "covers 400-500 nm" in words(shown("bake_advanced"))
    with pytest.raises(RuntimeError, match="covers 400-500 nm"):
        bpy.ops.diffraction.bake()
    state.illuminant_file = ""
    assert "none is chosen" in words(shown("bake_advanced"))
    with pytest.raises(RuntimeError, match="none is chosen"):
        bpy.ops.diffraction.bake()
    bake(illuminant_file="//lamp.csv")
    (project / "lamp.csv").unlink()
    with pytest.raises(RuntimeError, match="cannot be read"):  # the caller names it, so it must be there
        bpy.ops.diffraction.bake(illuminant_file="//lamp.csv")
    with pytest.raises(RuntimeError, match="cannot be read"):  # another name: not the kept values
        bpy.ops.diffraction.bake(illuminant_file="//other.csv")


def test_saved_elsewhere_the_file_is_found_again(project, tmp_path_factory):
    state = bake(illuminant_file="//lamp.csv")
    there = tmp_path_factory.mktemp("elsewhere")
    bpy.ops.wm.save_as_mainfile(filepath=str(there / "scene.blend"))
    state = bpy.context.scene.diffraction
    assert (there / state.illuminant_file.removeprefix("//")).resolve() == (project / "lamp.csv").resolve()
    assert json.loads(state.table_recipe)["settings"]["illuminant"] == "FILE"
