# SPDX-License-Identifier: GPL-3.0-or-later
"""What the surface adds to the table: back faces, bumps, reflectances, the pigment below, and the light's colour."""

import bpy
import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import materials, scenes, tables
from tests.support.blender.sphere_truth import expected
from tests.support.compare import assert_images_agree
from tests.truth import radiance

BOTH = pytest.mark.parametrize("implementation", ["OSL", "NODES"])


def dark(u, v, w):
    """No diffraction at all."""
    return np.zeros((*np.shape(u), 3))


def unit(*vector):
    return np.array(vector) / np.linalg.norm(vector)


@BOTH
@pytest.mark.parametrize("sun", [(0.3, 0.2, 1.0), (0.3, 0.2, -1.0)])
def test_seen_from_behind_nothing_diffracts(blender, tmp_path, implementation, sun):
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane = scenes.add_plane()
    scenes.add_sun(sun)
    scenes.add_camera((0.1, -0.2, -1.0), extent=1.0)
    materials.diffracting(plane, tmp_path / "t.exr", implementation=implementation, fresnel="NONE", environment=1)
    assert scenes.render(8, samples=4).max() == 0.0


@BOTH
def test_light_below_the_surface_and_at_its_horizon(blender, tmp_path, implementation):
    """A plane lit from below is black; a ball lit along the view's horizon is finite everywhere, black behind."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    ball = scenes.add_sphere(segments=64, rings=32)
    sun = scenes.add_sun((1.0, 0.0, 1e-7))
    scenes.add_camera((0.0, 0.0, 1.0))
    materials.diffracting(ball, tmp_path / "t.exr", implementation=implementation, fresnel="NONE", environment=0)
    image = scenes.render(64)
    assert np.isfinite(image).all()
    assert image.max() > 0.1
    hit, _, _, _, n = scenes.sphere_frames(ball, 64)
    assert image[hit & (n[..., 0] < -0.05)].max() == 0.0
    bpy.data.objects.remove(ball)
    bpy.data.objects.remove(sun)
    plane = scenes.add_plane()
    scenes.add_sun((0.5, 0.1, -0.02))
    materials.diffracting(plane, tmp_path / "t.exr", implementation=implementation, fresnel="NONE", environment=0)
    assert scenes.render(8, samples=4).max() == 0.0


@BOTH
def test_bump_of_the_pigment_tilts_the_surface(blender, tmp_path, implementation):
    """Heights that rise by 0.3 along x: the plane shines as one whose normal is (-0.3, 0, 1)."""
    from diffraction_shader.addon.materials import material

    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane, sun, view = scenes.add_plane(), unit(-0.6, -0.2, 0.9), unit(-0.1, 0.2, 1.0)
    scenes.add_sun(sun)
    scenes.add_camera(view, extent=0.2)
    made = materials.white_diffuse(plane)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = next(node for node in nodes if node.bl_idname == "ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (0, 0, 0, 1)
    place, split, slope, bump = (nodes.new(f"ShaderNode{n}") for n in ("TexCoord", "SeparateXYZ", "Math", "Bump"))
    slope.operation, slope.inputs[1].default_value = "MULTIPLY", 0.3
    bump.inputs["Strength"].default_value = bump.inputs["Distance"].default_value = 1.0
    links.new(place.outputs["Object"], split.inputs[0])
    links.new(split.outputs["X"], slope.inputs[0])
    links.new(slope.outputs[0], bump.inputs["Height"])
    links.new(bump.outputs["Normal"], shader.inputs["Normal"])
    bpy.context.view_layer.update()
    settings = material.Settings(implementation=implementation, fresnel="NONE", environment=0)
    material.apply(made, tmp_path / "t.exr", settings)
    image = scenes.render(4).mean((0, 1))
    n = unit(-0.3, 0, 1)
    t = unit(*(np.array((1, 0, 0)) - n[0] * n))
    wi, wr = (radiance.local(direction, t, np.cross(n, t), n) for direction in (sun, view))
    truth = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr), xyz_to_rgb_matrix())
    flat = radiance.gamut_step(radiance.f_cos_xyz(table, sun, view), xyz_to_rgb_matrix())
    assert np.abs(truth / flat - 1).max() > 0.1
    assert image == pytest.approx(truth, rel=0.01)


def conductor(n, k, cosine):
    """Unpolarised reflectance from the complex index of refraction, Fresnel's formulas as they stand."""
    m = n + 1j * k
    inside = np.sqrt(m**2 - (1 - cosine**2) + 0j)
    rs, rp = (cosine - inside) / (cosine + inside), (m**2 * cosine - inside) / (m**2 * cosine + inside)
    return 0.5 * (np.abs(rs) ** 2 + np.abs(rp) ** 2)


@BOTH
def test_conductor_is_fresnels(blender, tmp_path, implementation):
    """Copper: each of red, green and blue by its own index, at half-angles up to 60 degrees."""
    n, k = (0.27, 0.68, 1.14), (3.6, 2.6, 2.4)
    table = tables.make_table(tmp_path / "t.exr", tables.lobes)
    sphere, sun, view = scenes.add_sphere(), unit(0.9, 0.2, -0.3), unit(-0.5, 0.1, 0.6)
    scenes.add_sun(sun)
    scenes.add_camera(view)
    made = materials.diffracting(
        sphere, tmp_path / "t.exr", implementation=implementation, fresnel="CONDUCTOR", environment=0
    )
    inputs = made.node_tree.nodes["Diffraction"].inputs
    inputs["ConductorN"].default_value, inputs["ConductorK"].default_value = n, k
    truth, good = expected(sphere, table, [sun], 64)
    cosine = np.sqrt(0.5 * (1 + sun @ view))
    truth = truth * [conductor(a, b, cosine) for a, b in zip(n, k, strict=True)]
    assert np.degrees(np.arccos(cosine)) > 50
    assert good.sum() > 100
    assert_images_agree(scenes.render(64), truth, 0.01, where=good, name="conductor")


@BOTH
@pytest.mark.parametrize("fresnel", ["DIELECTRIC", "SCHLICK"])
@pytest.mark.parametrize("theta", [10, 75])
def test_pigment_gets_what_is_not_reflected(blender, tmp_path, implementation, theta, fresnel):
    """White paint under a surface that does not diffract: (1 - R) cos(theta_i) / pi, R at the view angle."""
    tables.make_table(tmp_path / "t.exr", dark)
    plane, sun = scenes.add_plane(), unit(0.2, -0.3, 0.8)
    scenes.add_sun(sun, strength=3.0)
    angle = np.radians(theta)
    scenes.add_camera((np.sin(angle), 0, np.cos(angle)), extent=0.3)
    materials.diffracting(
        plane, tmp_path / "t.exr", implementation=implementation, pigment=(0.9, 0.6, 0.3, 1), ior=1.8, environment=0,
        fresnel=fresnel,
    )  # fmt: skip
    r0 = (0.8 / 2.8) ** 2
    left = 1 - (r0 + (1 - r0) * (1 - np.cos(angle)) ** 5)
    if fresnel == "DIELECTRIC":
        left = 1 - conductor(1.8, 0.0, np.cos(angle))
    image = scenes.render(8, samples=16).mean((0, 1))
    assert image == pytest.approx(np.array((0.9, 0.6, 0.3)) * left * 3.0 * sun[2] / np.pi, rel=0.005)


@BOTH
def test_colour_of_lamp_and_exposure_of_film_count(blender, tmp_path, implementation):
    """The lamp's colour and power multiply what diffracts, the film's exposure multiplies all of it."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    plane, sun = scenes.add_plane(), scenes.add_sun((0.3, -0.2, 0.9))
    scenes.add_camera((0.1, 0.2, 1.0), extent=0.3)
    materials.diffracting(plane, tmp_path / "t.exr", implementation=implementation, fresnel="NONE", environment=0)
    white = scenes.render(8).mean((0, 1))
    sun.data.color, sun.data.energy = (1.0, 0.5, 0.25), 2.0
    assert scenes.render(8).mean((0, 1)) == pytest.approx(2.0 * white * (1.0, 0.5, 0.25), rel=1e-3)
    bpy.context.scene.cycles.film_exposure = 3.0
    assert scenes.render(8).mean((0, 1)) == pytest.approx(6.0 * white * (1.0, 0.5, 0.25), rel=1e-3)
