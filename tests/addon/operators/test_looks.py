# SPDX-License-Identifier: GPL-3.0-or-later
"""A preset chosen in the panel sets what suits it; a script's only when it says so."""

import bpy
import pytest

from precompute.presets import LOOKS

pytestmark = pytest.mark.usefixtures("blender")


def test_only_on_request(tmp_path):
    from diffraction_shader.addon.tables import estimates

    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    state = bpy.context.scene.diffraction
    names = list(LOOKS["cd"].settings())
    before = [getattr(state, name) for name in names]
    assert bpy.ops.diffraction.make_preset(preset="cd", pixels=64) == {"FINISHED"}
    assert [getattr(state, name) for name in names] == before
    state.use_crop, state.smooth_nm = True, 12.0  # of an earlier scan
    assert bpy.ops.diffraction.make_preset(preset="cd", pixels=64, look=True) == {"FINISHED"}
    for name, value in LOOKS["cd"].settings().items():
        assert getattr(state, name) == (pytest.approx(value) if isinstance(value, float) else value)
    assert (state.use_crop, state.smooth_nm) == (False, 0.0)
    # A patch on which the window of sunlight fits, unless the caller names its side.
    sides = []
    for given in ({}, {"size_um": 20.0}):
        bpy.ops.diffraction.make_preset(preset="cd", pixels=64, look=True, **given)
        sides.append(estimates.estimate(bpy.context.scene, wait=True))
    assert sides[0].size_m[0] == pytest.approx(LOOKS["cd"].patch_um * 1e-6)
    assert sides[1].size_m[0] == pytest.approx(20e-6)


def test_coherence_of_sunlight_is_a_button(tmp_path):
    """16.25 um on a wide patch; a quarter of the side and a warning on a small one."""
    from diffraction_shader.addon.tables import estimates

    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    state = bpy.context.scene.diffraction
    assert not bpy.ops.diffraction.coherence_of_sunlight.poll()
    for side_um, sigma_um in ((80.0, 16.25), (40.0, 10.0)):
        bpy.ops.diffraction.make_preset(preset="flat", pixels=64, size_um=side_um)
        assert bpy.ops.diffraction.coherence_of_sunlight() == {"FINISHED"}
        assert state.sigma_s_um == pytest.approx(sigma_um)
    state.ensemble, state.sigma_s_um = "single", 16.25
    found = estimates.estimate(bpy.context.scene, wait=True)
    assert "side lobes of 1.4e-02" in found.coherence.warning


@pytest.mark.parametrize("name", LOOKS)
def test_every_look_can_be_set(name):
    state = bpy.context.scene.diffraction
    for key, value in LOOKS[name].settings().items():
        setattr(state, key, value)
        assert getattr(state, key) == (pytest.approx(value) if isinstance(value, float) else value)


def test_a_person_gets_the_look(monkeypatch):
    """A button or the search invoke; the operator's own property says no by default."""
    from diffraction_shader.addon.jobs.threaded import Threaded
    from diffraction_shader.addon.operators.make_preset import DIFFRACTION_OT_make_preset as operator

    monkeypatch.setattr(Threaded, "invoke", lambda self, context, event: {"RUNNING_MODAL"})
    for given, look in ((set(), True), ({"look"}, False)):
        said = type("Said", (), {"is_property_set": lambda self, name, ghost=True, given=given: name in given})()
        person = type("Person", (), {"properties": said, "look": False})()
        assert operator.invoke(person, bpy.context, None) == {"RUNNING_MODAL"}
        assert person.look is look
