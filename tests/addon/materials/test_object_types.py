# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of object: surfaces diffract as the mesh that they become, strands and points show their pigment."""

import bpy
import numpy as np
import pytest

from tests.support.blender import extension, materials, scenes, tables


@pytest.fixture
def lit(blender, tmp_path):
    """A sun, a camera and the path of a table."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    scenes.add_sun((0.3, 0.1, 0.9))
    scenes.add_camera()
    return tmp_path / "t.exr"


def link(name, data):
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def curve():
    data = bpy.data.curves.new("curve", "CURVE")
    data.dimensions, data.bevel_depth = "3D", 0.3
    points = data.splines.new("POLY").points
    points.add(1)
    points[0].co, points[1].co = (-1, 0, 0, 1), (1, 0.2, 0.3, 1)
    return link("curve", data)


def text():
    data = bpy.data.curves.new("text", "FONT")
    data.body, data.extrude, data.align_x, data.align_y = "ab", 0.1, "CENTER", "CENTER"
    return link("text", data)


def metaball():
    data = bpy.data.metaballs.new("ball")
    data.elements.new()
    data.resolution = data.render_resolution = 0.2
    return link("ball", data)


def surface():
    bpy.ops.surface.primitive_nurbs_surface_sphere_add()
    return bpy.context.object


def as_mesh(ob):
    """The mesh that an object becomes, in its place."""
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    mesh = bpy.data.meshes.new_from_object(ob.evaluated_get(depsgraph), depsgraph=depsgraph)
    made = link("mesh", mesh)
    made.matrix_world = ob.matrix_world
    return made


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
@pytest.mark.parametrize("make", [curve, *(pytest.param(f, marks=pytest.mark.slow) for f in (text, metaball, surface))])
def test_surfaces_are_as_their_mesh(lit, make, implementation):
    ob = make()
    made = materials.diffracting(ob, lit, implementation, fresnel="NONE", environment=0)
    here = scenes.render(24, samples=16)
    mesh = as_mesh(ob)
    mesh.data.materials.clear()
    mesh.data.materials.append(made)
    bpy.data.objects.remove(ob)
    there = scenes.render(24, samples=16)
    assert here.max() > 0.1
    assert abs(here.mean() - there.mean()) < 0.01 * there.mean()


def hair():
    """A bald ball's hair, which alone is seen."""
    ball = scenes.add_sphere(segments=16, rings=8)
    settings = ball.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type, settings.count, settings.hair_length = "HAIR", 60, 0.5
    settings.root_radius = 5.0
    ball.show_instancer_for_render = False
    return ball


def strands():
    data = bpy.data.hair_curves.new("strands")
    data.add_curves([4] * 40)
    rng = np.random.default_rng(3)
    start, along = rng.normal(size=(40, 1, 3)) * 0.5, rng.normal(size=(40, 1, 3)) * 0.3
    places = start + along * np.arange(4)[:, None]
    data.position_data.foreach_set("vector", places.astype(np.float32).ravel())
    radius = data.attributes.get("radius") or data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.full(160, 0.03, np.float32))
    return link("strands", data)


def points():
    """Spheres that geometry nodes make of vertices."""
    mesh = bpy.data.meshes.new("points")
    mesh.from_pydata([(0, 0, 0), (0.6, 0.6, 0), (-0.6, -0.6, 0)], [], [])
    ob = link("points", mesh)
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    given, out, cloud, paint = (
        tree.nodes.new(kind)
        for kind in ("NodeGroupInput", "NodeGroupOutput", "GeometryNodeMeshToPoints", "GeometryNodeSetMaterial")
    )
    cloud.inputs["Radius"].default_value = 0.4
    for a, b in ((given, cloud), (cloud, paint), (paint, out)):
        tree.links.new(a.outputs[0], b.inputs[0])
    ob.modifiers.new("points", "NODES").node_group = tree
    return ob


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
@pytest.mark.parametrize("make", [hair, strands, points])
def test_strands_and_points_show_their_pigment(lit, make, implementation):
    """Their normals turn towards the viewer and their tangents run anywhere: not a thousand times the light."""
    ob = make()
    made = materials.diffracting(ob, lit, implementation, pigment=(0.1, 0.2, 0.3, 1), fresnel="NONE", environment=1)
    if make is points:
        paint = ob.modifiers[0].node_group.nodes["Set Material"]
        paint.inputs["Material"].default_value = made
    here = scenes.render(24, samples=16)
    made.node_tree.nodes["Diffraction"].inputs["Mask"].default_value = 0.0
    alone = scenes.render(24, samples=16)
    assert alone.max() > 0.01
    np.testing.assert_allclose(here, alone, rtol=1e-4, atol=1e-5)


def test_apply_says_why_not_on_hair(lit):
    extension.load()
    bpy.context.scene.diffraction.table_path = str(lit)
    ob = strands()
    bpy.context.view_layer.update()
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob
    with pytest.raises(RuntimeError, match="Hair and point clouds have no place for a scan"):
        bpy.ops.diffraction.apply_material()
