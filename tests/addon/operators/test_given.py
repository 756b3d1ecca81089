# SPDX-License-Identifier: GPL-3.0-or-later
"""Script wins: what a caller passes is used, what it leaves out comes from the scene. (Panel wins: tests/window.)"""

import bpy
import pytest

from tests.support.blender import scenes

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def state(blender, tmp_path):
    """The scene's group in a saved file."""
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    return bpy.context.scene.diffraction


class Remembering:
    """Properties of an operator that a button started: given ones, and those of the last run, which Blender marks."""

    def __init__(self, given, remembered):
        self.given, self.remembered = given, remembered

    def is_property_set(self, name, /, *, ghost=True):
        return name in self.given or (name in self.remembered and not ghost)


def test_remembered_values_are_nobodys_wish():
    from diffraction_shader.addon.given import is_given, left_out, take

    operator = type("Operator", (), {"a": 1, "b": 2, "c": 3, "properties": Remembering({"a"}, {"b"})})()
    assert [is_given(operator, name) for name in "abc"] == [True, False, False]
    assert left_out(operator, "abc") == ["b", "c"]
    take(operator, type("Panel", (), {"p_a": 10, "p_b": 20, "p_c": 30})(), "abc", "p_")
    assert (operator.a, operator.b, operator.c) == (1, 20, 30)


def test_a_preset_takes_from_the_panel_what_the_script_leaves_out(state):
    state.preset, state.preset_size_um, state.preset_pixels = "sinusoid", 8.0, 64
    state.presets.sinusoid.period_um, state.presets.blazed.period_um = 1.25, 1.5
    assert bpy.ops.diffraction.make_preset() == {"FINISHED"}
    assert "64 x 64 px, 8 x 8 um" in state.scan_info and state.scan_path.endswith("sinusoid.gsf")
    heights = made(state)
    assert bpy.ops.diffraction.make_preset(preset="sinusoid", pixels=80, period_um=2.0) == {"FINISHED"}
    assert "80 x 80 px, 8 x 8 um" in state.scan_info
    assert made(state) == (2.0, 80) and heights == (1.25, 64)
    assert state.presets.sinusoid.period_um == 1.25  # what a script passes is not the panel's
    assert bpy.ops.diffraction.make_preset(preset="blazed") == {"FINISHED"}
    assert made(state)[0] == 1.5 and state.preset == "blazed"


def made(state):
    """Period in micrometres and pixels of the stored scan."""
    from precompute.readers import read_scan

    field = read_scan(bpy.path.abspath(state.scan_path))
    (step,) = [step for step in field.processing if step["step"] == "preset"]
    return step["parameters"]["period_um"], field.heights.shape[1]


def test_a_material_takes_from_the_panel_what_the_script_leaves_out(state):
    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=8.0)
    bpy.ops.diffraction.bake(detail=0.2)
    plane = scenes.add_plane()
    bpy.context.view_layer.update()
    plane.select_set(True)
    bpy.context.view_layer.objects.active = plane
    state.fresnel, state.ior, state.environment = "DIELECTRIC", 1.25, 3
    assert bpy.ops.diffraction.apply_material(environment=0) == {"FINISHED"}
    inputs = plane.active_material.node_tree.nodes["Diffraction"].inputs
    assert inputs["IOR"].default_value == pytest.approx(1.25)
    assert inputs["Environment"].default_value == 0
    state.fresnel = "CONDUCTOR"
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    inputs = plane.active_material.node_tree.nodes["Diffraction"].inputs
    assert inputs["Fresnel"].default_value == 2 and inputs["Environment"].default_value == 3
    assert (state.fresnel, state.environment) == ("CONDUCTOR", 3)


def test_a_bake_takes_from_the_panel_what_the_script_leaves_out(state):
    import json

    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=8.0)
    state.detail, state.level, state.sigma_s_um = 0.2, "plane", 0.5
    assert bpy.ops.diffraction.bake(sigma_s_um=0.7) == {"FINISHED"}
    settings = json.loads(state.table_recipe)["settings"]
    assert (settings["sigma_s_um"], settings["level"], settings["detail"]) == (0.7, "plane", 0.2)
    assert state.sigma_s_um == pytest.approx(0.7)  # the panel shows how the table was made


def test_a_map_takes_its_light_from_the_panel(state):
    bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=8.0)
    bpy.ops.diffraction.bake(detail=0.2)
    state.map_size, state.map_linear = 32, True
    assert bpy.ops.diffraction.brdf_map(theta=0.4) == {"FINISHED"}
    image = bpy.data.images["BRDF sinusoid"]
    assert tuple(image.size) == (32, 32) and image.is_float
    assert bpy.ops.diffraction.brdf_map(theta=0.4, size=48) == {"FINISHED"}
    assert tuple(bpy.data.images["BRDF sinusoid"].size) == (48, 48)


def test_what_belongs_to_one_file_is_not_remembered():
    """Blender remembers for the next run by a button whatever does not say that it must not."""
    group = bpy.ops.diffraction.import_scan.get_rna_type().properties
    kept = [p.identifier for p in group if p.identifier != "rna_type" and not p.is_skip_save]
    assert kept == []


def test_a_browser_that_is_left_says_nothing(state):
    """Blender cancels the operator with its file browser, before any job was made."""
    from diffraction_shader.addon.jobs import progress
    from diffraction_shader.addon.operators.import_scan import DIFFRACTION_OT_import_scan

    browser = type(
        "Browser", (), {"cancel": DIFFRACTION_OT_import_scan.cancel, "_jobs": DIFFRACTION_OT_import_scan._jobs}
    )
    progress.show("Baking", 0.5)  # of another operator
    try:
        browser().cancel(bpy.context)
        assert progress.running() is not None
    finally:
        progress.clear()
