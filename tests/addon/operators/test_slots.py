# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with several material slots: the active one or all of them, and it is said which."""

import bpy
import pytest

from tests.support.blender import extension, panels, scenes


@pytest.fixture
def plane(blender, tmp_path):
    """A plane with the slots Skin, Eyes and an empty one, Eyes active."""
    ob = scenes.plane_with_table(tmp_path)
    for name in ("Skin", "Eyes"):
        made = bpy.data.materials.new(name)
        extension.give_nodes(made)
        ob.data.materials.append(made)
    ob.data.materials.append(None)
    ob.active_material_index = 1
    return ob


def names(ob):
    return [slot.material.name if slot.material else None for slot in ob.material_slots]


def apply(**options):
    return bpy.ops.diffraction.apply_material(implementation="NODES", environment=0, **options)


def test_the_active_slot_and_the_panel_says_which(plane):
    assert "Only the active slots: Eyes of plane (2 of 3)" in panels.words(panels.shown("material"))
    assert apply() == {"FINISHED"}
    assert names(plane) == ["Skin", "Eyes diffraction", None]


def test_all_slots(plane):
    from diffraction_shader.addon.materials import material

    assert apply(all_slots=True) == {"FINISHED"}
    assert names(plane)[:2] == ["Skin diffraction", "Eyes diffraction"]
    assert all(material.is_ours(slot.material) for slot in plane.material_slots)


def test_slots_that_share_a_material_share_the_new_one(plane):
    plane.material_slots[2].material = plane.material_slots[0].material
    assert apply(all_slots=True) == {"FINISHED"}
    assert names(plane) == ["Skin diffraction", "Eyes diffraction", "Skin diffraction"]


def test_slots_of_the_object_itself(plane):
    """Linked to the object, not to its mesh."""
    plane.material_slots[1].link = "OBJECT"
    plane.material_slots[1].material = bpy.data.materials["Skin"]
    apply()
    assert names(plane)[1] == "Skin diffraction"
    assert plane.data.materials[1].name == "Eyes"


def test_one_slot_needs_no_word(plane):
    plane.data.materials.pop()
    plane.data.materials.pop()
    assert "Only the active" not in panels.words(panels.shown("material"))
