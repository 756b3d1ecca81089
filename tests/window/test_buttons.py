# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons that a day needs now and then, each pressed twice: copies, sliders, lost tables."""

import json
import re

import pytest

MATERIAL = "bpy.context.object.active_material"


@pytest.fixture(scope="module")
def day(enabled, work):
    """A saved file with two cubes that share a material."""
    enabled.new_file()
    folder = work / "buttons"
    folder.mkdir()
    enabled.run(f"""
with within('VIEW_3D', 'WINDOW'):
    bpy.ops.wm.save_as_mainfile(filepath={str(folder / "buttons.blend")!r})
    bpy.ops.diffraction.make_preset(preset='blazed', size_um=10, pixels=96, look=True)
    bpy.ops.diffraction.bake(detail=0.2)
    bpy.ops.diffraction.apply_material(implementation='NODES')
    bpy.ops.object.duplicate(linked=False)
    bpy.context.object.location.x = 4
""")
    enabled.open_sidebar()
    enabled.console()
    yield enabled
    enabled.new_file()


def test_own_copy_leaves_the_other_object_alone(day):
    shared = day.look(f"{MATERIAL}.name")
    day.run("bpy.context.scene.diffraction.rotation = 0.3")
    day.press(re.compile(r"apply_material\(.*own_copy=True"))
    assert day.look(f"{MATERIAL}.name") != shared
    day.run("""
other = bpy.context.scene.objects['Cube']
for each in bpy.context.scene.objects: each.select_set(each == other)
bpy.context.view_layer.objects.active = other
""")
    assert day.look(f"{MATERIAL}.name") == shared
    assert day.look(f"{MATERIAL}.node_tree.nodes['Diffraction'].inputs['Rotation'].default_value") == pytest.approx(0.0)
    assert day.console() == []


def test_sliders_of_the_active_material(day):
    socket = f"{MATERIAL}.node_tree.nodes['Diffraction'].inputs"
    for name, value in (("Fresnel", 1), ("Fresnel", 2)):
        day.press(re.compile(f"{name}.*value={value}"), share=0.3 if value == 1 else 0.6)
        assert day.look(f"{socket}[{name!r}].default_value") == value
    before = day.look(f"{socket}['ConserveEnergy'].default_value")
    for wanted in (1 - before, before):
        day.press(re.compile("context_set_int.*ConserveEnergy"))
        assert day.look(f"{socket}['ConserveEnergy'].default_value") == wanted
    day.shot("45_active_material")
    assert day.console() == []


def test_edit_table_brings_a_materials_settings_back(day):
    for sigma in (1.5, 2.5):
        day.run(f"bpy.context.scene.diffraction.sigma_s_um = {sigma}")
        day.press("diffraction.use_material_scan", share=0.83)
        assert day.state("sigma_s_um") == json.loads(day.state("table_recipe"))["settings"]["sigma_s_um"] != sigma
    assert day.console() == []


def test_lost_file_of_a_packed_table_is_no_loss(day):
    for times in range(2):
        day.run("import os\nos.remove(bpy.path.abspath(bpy.context.scene.diffraction.table_path))")
        day.run("with anywhere(): bpy.ops.wm.save_mainfile()")
        day.run("with anywhere(): bpy.ops.wm.open_mainfile(filepath=bpy.data.filepath)")
        day.open_sidebar()
        day.settle()
        day.shot(f"46_reopened_{times}")
        assert day.look("[text for _, text in addon('watch.places').problems()]") == []
        day.press("diffraction.bake")
        assert day.look("os.path.isfile(bpy.path.abspath(bpy.context.scene.diffraction.table_path))")
    assert day.console() == []
