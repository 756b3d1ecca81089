# SPDX-License-Identifier: GPL-3.0-or-later
"""World light, emitters and lamps together: stochastic mirrors against quadratures."""

import bpy
import numpy as np
import pytest

from precompute.light.colour import luminance_row, xyz_to_rgb_matrix
from tests.support.blender import extension, materials, scenes, tables
from tests.support.blender.worlds import white_world
from tests.truth import radiance
from tests.truth.hemisphere import hemisphere

VIEWS = [(0.0, 0.0, 1.0), (0.5, 0.3, 1.0), (-0.9, 0.4, 0.6)]


def reflected(table, wr, light=lambda wi: 1.0, conserve=True):
    """RGB that a patch reflects towards wr under light from everywhere, gamut step at each direction."""
    wi, cell = hemisphere()
    f_cos = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr, conserve), xyz_to_rgb_matrix())
    return (f_cos * (cell * light(wi))[..., None]).sum((0, 1))


def patch(tmp_path, view, environment=1, conserve=True, **table_options):
    table = tables.make_table(tmp_path / "t.exr", tables.gentle, **table_options)
    plane = scenes.add_plane(half=1.0)
    scenes.add_camera(view, extent=0.5)
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE", environment=environment, conserve_energy=conserve)
    return table, np.array(view) / np.linalg.norm(view)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize(("environment", "conserve"), [(1, False), (4, True)])
def test_white_world_shows_the_albedo(blender, tmp_path, view, environment, conserve):
    white_world()
    table, wr = patch(tmp_path, view, environment, conserve, albedo=lambda theta, phi: 0.6 / np.cos(0.99 * theta))
    image = scenes.render(32, samples=256)
    assert image.mean((0, 1)) == pytest.approx(reflected(table, wr, conserve=conserve), rel=0.01)


def test_gradient_sky(blender, tmp_path):
    """Bright on one side, dark on the other, blueish above: unbiased for light that varies."""
    world = white_world()
    nodes, links = world.node_tree.nodes, world.node_tree.links
    place, split, add = (nodes.new(f"ShaderNode{name}") for name in ("TexCoord", "SeparateXYZ", "Math"))
    add.inputs[1].default_value = 1.2
    links.new(place.outputs["Generated"], split.inputs[0])
    links.new(split.outputs["X"], add.inputs[0])
    links.new(add.outputs[0], nodes["Background"].inputs["Strength"])
    table, wr = patch(tmp_path, (0.5, 0.3, 1.0))
    image = scenes.render(32, samples=128)
    expected = reflected(table, wr, light=lambda wi: wi[..., 0] + 1.2)
    assert image.mean((0, 1)) == pytest.approx(expected, rel=0.01)


def test_sun_and_world_do_not_count_twice(blender, tmp_path):
    """A sun of 0.1 rad in a white world: the sum of both alone."""
    white_world()
    scenes.add_sun((0.3, -0.2, 0.9), strength=2.0, angle=0.1)
    table, wr = patch(tmp_path, (0.5, 0.3, 1.0))
    image = scenes.render(32, samples=256).mean((0, 1))
    wi = np.array((0.3, -0.2, 0.9)) / np.linalg.norm((0.3, -0.2, 0.9))
    by_sun = 2.0 * radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr), xyz_to_rgb_matrix())
    assert image == pytest.approx(by_sun + reflected(table, wr), rel=0.01)


def test_emitting_mesh_is_seen(blender, tmp_path):
    """A glowing square above, against a sum over its surface."""
    panel = scenes.add_plane("panel", half=0.5)
    panel.location = (0.3, 0.2, 0.9)
    panel.rotation_euler = (np.pi, 0, 0)
    panel.visible_camera = False
    glow = bpy.data.materials.new("glow")
    extension.give_nodes(glow)
    glow.node_tree.nodes.clear()
    emission, output = (glow.node_tree.nodes.new(f"ShaderNode{name}") for name in ("Emission", "OutputMaterial"))
    emission.inputs["Strength"].default_value = 3.0
    glow.node_tree.links.new(emission.outputs[0], output.inputs[0])
    panel.data.materials.append(glow)
    view = (0.1, -0.6, 1.0)
    table = tables.make_table(tmp_path / "t.exr", tables.gentle)
    plane = scenes.add_plane(half=0.05)
    scenes.add_camera(view, extent=0.04, distance=0.6)
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    bpy.context.scene.cycles.max_bounces = 1
    image = scenes.render(32, samples=256).mean((0, 1))
    wr = np.array(view) / np.linalg.norm(view)
    side = (np.arange(200) + 0.5) / 200 - 0.5
    x, y = np.meshgrid(side, side)
    points = np.stack([0.3 + x, 0.2 + y, np.full_like(x, 0.9)], -1)
    distance = np.linalg.norm(points, axis=-1)
    wi = points / distance[..., None]
    solid_angle = wi[..., 2] / distance**2 / 200**2
    f_cos = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr), xyz_to_rgb_matrix())
    expected = 3.0 * (f_cos * solid_angle[..., None]).sum((0, 1))
    assert image == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("theta", [0, 40, 60])
def test_snake_in_a_white_furnace(blender, snake, theta):
    """Mean equal to the quadrature of the table, never above 1; noise at 64 samples below 14 percent."""
    table, path = snake
    white_world()
    plane = scenes.add_plane(half=1.0)
    view = (0.6 * np.sin(np.radians(theta)), 0.8 * np.sin(np.radians(theta)), np.cos(np.radians(theta)))
    scenes.add_camera(view, extent=0.5)
    materials.diffracting(plane, path, fresnel="NONE")
    image = scenes.render(64, samples=64)
    # The gamut step keeps luminance, so that Y tells the truth whatever it does to single directions.
    luminance = image @ luminance_row()
    wi, cell = hemisphere(1500)
    expected = (radiance.f_cos_xyz(table, wi, np.array(view))[..., 1] * cell).sum()
    assert luminance.mean() == pytest.approx(expected, rel=0.01)
    assert (image.mean((0, 1)) <= 1.01).all()
    assert luminance.std() / luminance.mean() < 0.14


def test_noise_has_no_structure_far_from_the_origin(blender, tmp_path):
    """Camera and surface a thousand units away, orthographic: neighbouring pixels stay independent."""
    white_world()
    tables.make_table(tmp_path / "t.exr", tables.gentle)
    plane = scenes.add_plane(half=1.0)
    camera = scenes.add_camera((0.2, 0.1, 1.0), extent=0.5)
    for ob in (plane, camera):
        ob.location.x += 1000.0
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE")
    noise = scenes.render(64, samples=4)[..., 1]
    noise = (noise - noise.mean()) / noise.std()
    for axis in (0, 1):
        for shift in (1, 2, 3):
            assert abs((noise * np.roll(noise, shift, axis)).mean()) < 0.06  # 4 / sqrt(4096)
    spectrum = np.abs(np.fft.fft2(noise)) ** 2 / noise.size
    assert spectrum.max() < 25.0  # of white noise: exponential with mean 1
