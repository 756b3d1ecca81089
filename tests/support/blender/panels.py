# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels show, and the steps of the work that their buttons take."""

import json
import re

import bpy

from tests.support.blender import scenes


def all_panels():
    return [
        getattr(bpy.types, name)
        for name in dir(bpy.types)
        if name.startswith("DIFFRACTION_PT_") and getattr(getattr(bpy.types, name), "bl_category", "") == "Diffraction"
    ]


def draw(cls):
    """What a panel shows: None where its poll says no, else the text of its header and body."""
    if hasattr(cls, "poll") and not cls.poll(bpy.context):
        return None
    text = ""
    for name in ("draw_header", "draw_header_preset", "draw"):
        if hasattr(cls, name):
            layout = bpy.context.window_manager.popmenu_begin__internal("test").layout
            getattr(cls, name)(type("Panel", (), {"layout": layout, "bl_label": cls.bl_label}), bpy.context)
            text += json.dumps(layout.introspect(), default=str, ensure_ascii=False)
    return text


def shown(name):
    return draw(getattr(bpy.types, f"DIFFRACTION_PT_{name}"))


def words(text):
    """The words of all labels in their order; sentences are wrapped over several labels."""
    return " ".join(" ".join(re.findall(r'"draw_string": "([^"]*)"', text)).split())


def everything():
    """All panels drawn, in one text; drawing must never fail."""
    return " ".join(text for cls in all_panels() if (text := draw(cls)) is not None)


def preset(**options):
    assert bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=10, **options) == {"FINISHED"}
    return bpy.context.scene.diffraction


def plane_with_material():
    plane = scenes.add_plane()
    scenes.add_sun((0.1, 0.2, 1.0))
    bpy.context.view_layer.update()
    plane.select_set(True)
    bpy.context.view_layer.objects.active = plane
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    return plane
