# SPDX-License-Identifier: GPL-3.0-or-later
"""Script nodes where Blender's Python hides oslquery, as the bpy module does."""

import bpy

from tests.support.blender import extension, materials, scenes, tables


def test_sockets_without_oslquery_are_those_that_blender_makes(blender, monkeypatch, tmp_path):
    extension.load()
    from diffraction_shader.addon.materials import script_node
    from diffraction_shader.addon.materials.node import group

    tables.make_table(tmp_path / "t.exr", tables.lobes)
    scenes.add_sun((0.2, 0.1, 1.0))
    scenes.add_camera()
    found = []
    for hidden in (False, True):
        if hidden:
            monkeypatch.setattr(script_node.importlib.util, "find_spec", lambda name: None)
        plane = scenes.add_plane(f"plane {hidden}")
        tree = group.owner(materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE"))
        node = group.script_of(tree)
        sockets = [
            (
                s.name,
                s.bl_idname,
                tuple(s.default_value) if s.bl_idname == "NodeSocketVector" else getattr(s, "default_value", None),
            )
            for s in (*node.inputs, *node.outputs)
        ]
        found.append((sockets, node.bytecode))
        assert scenes.render(8).max() > 0.1
        bpy.data.objects.remove(plane)
        bpy.data.node_groups.remove(tree)
    assert [s[:2] for s in found[1][0]] == [s[:2] for s in found[0][0]]
    assert found[1][0] == found[0][0]


def test_parameters_are_read_from_compiled_text():
    extension.load()
    from diffraction_shader.addon.materials.script_node import parameters

    compiled = (
        "OpenShadingLanguage 1.00\n"
        "param\tint\tA\t3\t%read{1,2}\n"
        'param\tstring\tS\t"x.exr"\n'
        "oparam\tclosure color\tOut\t\t%write{0,1}\n"
    )
    assert parameters(compiled) == [
        (False, "int", "A", ["3"]),
        (False, "string", "S", ['"x.exr"']),
        (True, "closure color", "Out", []),
    ]
