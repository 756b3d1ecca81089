# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles against numpy, per pixel: a sphere under suns without size."""

import bpy  # before mathutils, which comes with it
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import extension, scenes, tables
from tests.support.blender.sphere_truth import expected
from tests.support.compare import assert_images_agree
from tests.truth import radiance


def diffracting(ob, table_path, lamps=None, **settings):
    """Give an object a material of ours and return it."""
    extension.load()
    from diffraction_shader.addon.materials import material

    bpy.context.view_layer.update()
    made = bpy.data.materials.new(ob.name)
    extension.give_nodes(made)
    made.node_tree.nodes.clear()
    material.apply(made, table_path, material.Settings(**settings))
    made.node_tree.nodes["Pigment"].inputs["Color"].default_value = (0, 0, 0, 1)
    ob.data.materials.append(made)
    return made


@pytest.mark.parametrize("conserve", [True, False])
def test_sphere_under_one_sun(blender, tmp_path, conserve):
    table = tables.make_table(tmp_path / "t.exr", tables.lobes, albedo=tables.rising)
    sphere, direction = scenes.add_sphere(), (0.3, -0.4, 0.8)
    scenes.add_sun(direction)
    scenes.add_camera((0.2, 0.1, 1.0))
    diffracting(sphere, tmp_path / "t.exr", fresnel="NONE", conserve_energy=conserve)
    image = scenes.render()
    truth, good = expected(sphere, table, [direction], 96, conserve=conserve)
    assert good.sum() > 2000
    assert_images_agree(image, truth, 0.01, where=good, name=f"sun_{conserve}")


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
@pytest.mark.parametrize(("fresnel", "form"), [("DIELECTRIC", radiance.dielectric), ("SCHLICK", radiance.schlick)])
def test_fresnel_of_a_dielectric(blender, tmp_path, implementation, fresnel, form):
    """Half-angles of 50 degrees and more, where the two differ by a tenth and more."""
    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere, direction = scenes.add_sphere(), (0.9, 0.2, -0.3)
    scenes.add_sun(direction)
    scenes.add_camera((-0.5, 0.1, 0.6))
    diffracting(sphere, tmp_path / "t.exr", implementation=implementation, fresnel=fresnel, ior=1.8, environment=0)
    truth, good = expected(sphere, table, [direction], 96, reflectance=lambda wi, wr: form(1.8, wi, wr))
    assert good.sum() > 200
    assert_images_agree(scenes.render(), truth, 0.01, where=good, name=f"{fresnel} {implementation}")


@pytest.mark.parametrize("shared", [False, True])
def test_rotated_scaled_parented_object_and_lamp(blender, tmp_path, shared):
    """Uneven scale, a mirrored axis, a parent on either side: the frame follows the surface, the sun its object.

    Cycles applies the transform to a mesh of one object and keeps it apart where several share the mesh.
    """
    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    parent = bpy.data.objects.new("parent", None)
    parent.rotation_euler = (0.4, -0.3, 0.9)
    parent.scale = (0.8, -1.0, 1.3)
    lamp_parent = bpy.data.objects.new("lamp parent", None)
    lamp_parent.rotation_euler = (0.5, 0.2, -0.4)
    lamp_parent.scale = (1.0, 2.0, 0.5)
    for empty in (parent, lamp_parent):
        bpy.context.scene.collection.objects.link(empty)
    matrix = Matrix.LocRotScale(Vector((0.05, -0.1, 0.2)), Euler((0.3, 0.8, -0.2)), Vector((0.6, 0.7, 0.5)))
    sphere = scenes.add_sphere(matrix=matrix, parent=parent)
    if shared:
        other = bpy.data.objects.new("elsewhere", sphere.data)
        other.location = (0, 0, -50)
        bpy.context.scene.collection.objects.link(other)
    sun = scenes.add_sun((0.1, 0.3, 0.9), parent=lamp_parent)
    scenes.add_camera((0.3, -0.2, 1.0))
    diffracting(sphere, tmp_path / "t.exr", fresnel="NONE")
    image = scenes.render()
    direction = np.array(sun.matrix_world)[:3, 2]
    truth, good = expected(sphere, table, [direction], 96)
    assert good.sum() > 1000
    assert_images_agree(image, truth, 0.01, where=good, name="transformed")


@pytest.mark.parametrize("mirrored", [False, True])
def test_light_from_the_right_lights_the_side_that_a_tilted_facet_faces(blender, tmp_path, mirrored):
    """T that lives at u > 0 only: u = -(wi + wr).t, so light and viewer together stand towards -t.

    Picture a sawtooth whose facets rise along t: they face -t, and a viewer above sees them shine when
    the lamp stands at -t. With a mirrored UV map t points the other way, and so does everything.
    """
    tables.make_table(tmp_path / "t.exr", lambda u, v, w: np.where(u > 0.05, 1.0, 0.0)[..., None] * tables.WHITE)
    side = 1.0 if mirrored else -1.0
    brightness = {}
    plane = scenes.add_plane(mirrored=mirrored)
    scenes.add_camera((0, 0, 1), extent=1.0)
    sun = scenes.add_sun((0, 0, 1))
    diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    for x in (-1.0, 1.0):
        sun.rotation_quaternion = Vector((0.5 * x, 0, 0.85)).to_track_quat("Z", "Y")
        brightness[x] = scenes.render(size=8).mean()
    assert brightness[side] > 0.5
    assert brightness[-side] < 1e-6


@pytest.mark.parametrize("mirrored", [False, True])
def test_v_grows_upwards_whichever_way_u_runs(blender, tmp_path, mirrored):
    tables.make_table(tmp_path / "t.exr", lambda u, v, w: np.where(v > 0.05, 1.0, 0.0)[..., None] * tables.WHITE)
    plane = scenes.add_plane(mirrored=mirrored)
    scenes.add_camera((0, 0, 1), extent=1.0)
    sun = scenes.add_sun((0, -0.5, 0.85))
    diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    assert scenes.render(size=8).mean() > 0.5
    sun.rotation_quaternion = Vector((0, 0.5, 0.85)).to_track_quat("Z", "Y")
    assert scenes.render(size=8).mean() < 1e-6


def test_eight_suns_add_up_even_where_their_cones_would_overlap(blender, tmp_path):
    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere = scenes.add_sphere()
    directions = [(0.1, 0.1, 1), (0.16, 0.1, 1), (-0.5, 0.2, 0.9), (0.4, -0.6, 0.7), (0.4, 0.5, 0.8), (-0.3, -0.5, 0.8),
                  (0.7, 0.0, 0.7), (0.0, 0.7, 0.8)]  # fmt: skip
    for number, direction in enumerate(directions):
        scenes.add_sun(direction, name=f"sun {number}")
    scenes.add_camera()
    diffracting(sphere, tmp_path / "t.exr", fresnel="NONE")
    image = scenes.render(samples=64)  # each sample picks one lamp
    truth, good = expected(sphere, table, directions, 96)
    assert image[good].mean() == pytest.approx(truth[good].mean(), rel=0.01)


def test_nothing_from_below_and_no_nan(blender, tmp_path):
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere = scenes.add_sphere(segments=64, rings=32)
    scenes.add_sun((0.2, 0.1, -1.0))
    scenes.add_camera()
    diffracting(sphere, tmp_path / "t.exr", fresnel="NONE")
    image = scenes.render()
    assert np.isfinite(image).all()
    assert image[40:56, 40:56].max() == 0.0


def test_sphere_with_the_table_of_the_snake_preset(blender, snake):
    table, path = snake
    sphere, direction = scenes.add_sphere(segments=768, rings=384), (0.3, -0.4, 0.8)
    scenes.add_sun(direction)
    scenes.add_camera((0.2, 0.1, 1.0))
    diffracting(sphere, path, fresnel="DIELECTRIC", ior=1.55)
    truth, good = expected(sphere, table, [direction], 96, reflectance=lambda wi, wr: radiance.dielectric(1.55, wi, wr))
    assert good.sum() > 950
    assert_images_agree(scenes.render(), truth, 0.01, where=good, name="snake")


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_normal_map_of_the_pigment_tilts_the_surface(blender, tmp_path, implementation):
    """A tangent-space normal of (0.3, 0, 1) everywhere: the plane shines as one that is tilted by that much."""
    from diffraction_shader.addon.materials import material

    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane = scenes.add_plane()
    sun = np.array((0.4, -0.2, 0.9))
    scenes.add_sun(sun)
    scenes.add_camera((0.1, 0.2, 1.0), extent=0.2)
    made = bpy.data.materials.new("painted")
    extension.give_nodes(made)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    shader, bump, output = (nodes.new(f"ShaderNode{n}") for n in ("BsdfDiffuse", "NormalMap", "OutputMaterial"))
    shader.inputs["Color"].default_value = (0, 0, 0, 1)
    bump.inputs["Color"].default_value = (0.65, 0.5, 1.0, 1.0)
    links.new(bump.outputs[0], shader.inputs["Normal"])
    links.new(shader.outputs[0], output.inputs[0])
    bpy.context.view_layer.update()
    settings = material.Settings(implementation=implementation, fresnel="NONE", environment=0)
    material.apply(made, tmp_path / "t.exr", settings)
    plane.data.materials.append(made)
    image = scenes.render(4).mean((0, 1))
    n = np.array((0.3, 0, 1)) / np.linalg.norm((0.3, 0, 1))
    t = np.array((1, 0, 0)) - n[0] * n
    t /= np.linalg.norm(t)
    b = np.cross(n, t)
    wi, wr = (radiance.local(np.array(d) / np.linalg.norm(d), t, b, n) for d in (sun, (0.1, 0.2, 1.0)))
    assert image == pytest.approx(radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr), xyz_to_rgb_matrix()), rel=0.01)
