# SPDX-License-Identifier: GPL-3.0-or-later
"""Engine or device changed after Apply: the panel says what does not fit, and a button mends it. Linked materials."""

import bpy
import pytest

from tests.support.blender import panels, scenes

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def plane(blender, tmp_path):
    """A plane with an OSL material in a saved file."""
    ob = scenes.plane_with_table(tmp_path)
    assert bpy.ops.diffraction.apply_material(implementation="OSL", ior=1.4) == {"FINISHED"}
    return ob


def needs_osl(ob):
    from diffraction_shader.addon.materials import material

    return material.needs_osl(ob.active_material)


def test_what_fits_is_not_mentioned(plane):
    assert not bpy.ops.diffraction.fit_renderer.poll()
    assert "fit_renderer" not in panels.shown("material")


def test_osl_switched_off_is_switched_on(plane):
    bpy.context.scene.cycles.shading_system = False
    assert "Open Shading Language is off" in panels.words(panels.shown("material"))
    assert bpy.ops.diffraction.fit_renderer() == {"FINISHED"}
    assert bpy.context.scene.cycles.shading_system and needs_osl(plane)
    assert not bpy.ops.diffraction.fit_renderer.poll()


@pytest.mark.parametrize("change", ["engine", "device", "build"])
def test_where_osl_cannot_run_nodes_take_its_place(plane, monkeypatch, change):
    from diffraction_shader.addon import renderers

    if change == "engine":
        bpy.context.scene.render.engine = renderers.EEVEE
    elif change == "device":
        monkeypatch.setattr(renderers, "device_without_osl", lambda scene: "CUDA")
    else:
        monkeypatch.setattr(renderers, "has_osl", lambda: False)
    words = {"engine": "EEVEE", "device": "CUDA", "build": "built without"}[change]
    assert words in panels.words(panels.shown("material")) and "fit_renderer" in panels.shown("material")
    assert bpy.ops.diffraction.fit_renderer() == {"FINISHED"}
    assert not needs_osl(plane)
    assert plane.active_material.node_tree.nodes["Diffraction"].inputs["IOR"].default_value == pytest.approx(1.4)
    assert not bpy.ops.diffraction.fit_renderer.poll()


def test_a_linked_material_is_made_local(plane, tmp_path):
    plane.active_material.name = "grating"
    bpy.ops.wm.save_mainfile()
    library = bpy.data.filepath
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "other.blend"))
    with bpy.data.libraries.load(library, link=True, relative=True) as (_, into):
        into.materials = ["grating"]
    ob = scenes.add_plane()
    ob.data.materials.append(into.materials[0])
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = ob
    assert not ob.active_material.is_editable
    assert "make_local" in panels.shown("active")
    assert bpy.ops.diffraction.make_local() == {"FINISHED"}
    assert ob.active_material.is_editable and ob.active_material.name == "grating"
    assert not bpy.ops.diffraction.make_local.poll()
    assert bpy.ops.diffraction.rebake.poll()
