# SPDX-License-Identifier: GPL-3.0-or-later
"""Sockets Scale and Depth: pixel by pixel what numpy says, under lamps and in an environment, constant or painted."""

import bpy
import numpy as np
import pytest

from precompute.bake.baking import bake
from precompute.evaluate.scaled import ScaledTable
from precompute.light.colour import luminance_row, spectral_weights, xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.stack import parse_stack
from precompute.table.table import SpectralTable
from tests.support.blender import materials, scenes
from tests.support.blender.lamps import add_lamp
from tests.support.blender.sphere_truth import expected
from tests.support.blender.worlds import white_world
from tests.support.compare import assert_images_agree
from tests.truth import radiance
from tests.truth.hemisphere import direction, hemisphere

SUN = (0.3, -0.4, 0.8)
PAIRS = [(0.6, 0.7), (0.45, 1.0), (1.15, 1.1)]


@pytest.fixture(scope="module")
def foil(tmp_path_factory):
    path = tmp_path_factory.mktemp("foil") / "foil.exr"
    bake(make_preset("foil", 24e-6, 270), BakeParameters(sigma_s_m=1.5e-6, detail=0.6)).save(path)
    return SpectralTable.load(path), path


def node_of(made):
    return made.node_tree.nodes["Diffraction"]


@pytest.mark.parametrize(("scale", "depth"), PAIRS)
@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_a_sphere_under_a_sun_is_what_numpy_says(blender, foil, implementation, scale, depth):
    table, path = foil
    sphere = scenes.add_sphere(segments=512, rings=256)
    scenes.add_sun(SUN)
    scenes.add_camera((0.2, 0.1, 1.0))
    made = materials.diffracting(sphere, path, implementation, fresnel="NONE", environment=0)
    node_of(made).inputs["Scale"].default_value, node_of(made).inputs["Depth"].default_value = scale, depth
    image = scenes.render(48)
    truth, good = expected(sphere, ScaledTable(table, scale, depth), [SUN], 48)
    assert good.sum() > 200
    # Above 1 the table's rim is in view, which is as steep as a texel allows.
    most = 99.0 if scale <= 1.0 else 97.0
    assert_images_agree(image, truth, 0.01, most, where=good, name=f"scaled_{implementation}_{scale}_{depth}")


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_senseless_values_count_as_a_hundredth(blender, foil, implementation):
    _, path = foil
    plane = scenes.add_plane()
    scenes.add_sun(SUN)
    scenes.add_camera(extent=0.2)
    made = materials.diffracting(plane, path, implementation, fresnel="NONE", environment=0)
    node, found = node_of(made), []
    tree = made.node_tree
    value = tree.nodes.new("ShaderNodeMath")  # 0 / 0 is no number in OSL alone; Cycles' own division gives 0
    value.operation = "MULTIPLY"
    value.inputs[1].default_value = 1.0
    for name in ("Scale", "Depth"):
        tree.links.new(value.outputs[0], node.inputs[name])
    for number in (0.01, 0.0, -3.0, float("nan")):
        value.inputs[0].default_value = number
        found.append(scenes.render(4).mean((0, 1)))
    assert min(found[0]) > 0
    for each in found[1:]:
        assert each == pytest.approx(found[0], rel=1e-4)


def painted_plane(path, implementation, maps):
    """A plane whose sockets follow an image of Scale (R) and Depth (G), one texel a pixel of the render."""
    rows, cols = maps.shape[:2]
    plane = scenes.add_plane(half=1.0)
    made = materials.diffracting(plane, path, implementation, fresnel="NONE", environment=0)
    image = bpy.data.images.new("paint", cols, rows, float_buffer=True, alpha=True)
    image.colorspace_settings.name = "Non-Color"
    pixels = np.ones((rows, cols, 4), np.float32)
    pixels[..., :2] = maps
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    tree = made.node_tree
    texture, split = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeSeparateColor")
    texture.image, texture.interpolation = image, "Closest"
    tree.links.new(texture.outputs["Color"], split.inputs[0])
    tree.links.new(split.outputs["Red"], node_of(made).inputs["Scale"])
    tree.links.new(split.outputs["Green"], node_of(made).inputs["Depth"])
    return made


def painted_and_truth(table, path, implementation, count, render):
    """A picture of a plane of which each pixel has a Scale and a Depth of its own, what numpy says, what counts."""
    maps = np.random.default_rng(4).uniform(0.3, 1.1, (count, count, 2))
    view = (0.0, 0.0, 1.0)
    scenes.add_sun(SUN)
    scenes.add_camera(view, extent=2.0)
    painted_plane(path, implementation, maps)
    image = render(count)[::-1, ::-1]  # a camera straight above looks with the picture's top down
    wi = np.array(SUN) / np.linalg.norm(SUN)
    truth = np.zeros_like(image)
    for place in np.ndindex(count, count):
        one = ScaledTable(table, *maps[place])
        f_cos = radiance.f_cos_xyz(one, wi, np.array(view))
        truth[place] = radiance.gamut_step(f_cos[None], xyz_to_rgb_matrix())[0]
    good = (truth.mean(-1) > 1e-3) & ~np.eye(count, dtype=bool)  # rays meet the seam of the square's triangles there
    return image, truth, good


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_painted_pixels_are_each_their_own_surface(blender, foil, implementation):
    image, truth, good = painted_and_truth(*foil, implementation, 12, scenes.render)
    assert good.sum() > 30
    assert_images_agree(image, truth, 0.01, where=good, name=f"painted_{implementation}")


@pytest.mark.slow
def test_eevee_paints_each_pixel_as_its_own_surface(blender, foil):
    """Scale from 0.3 to 1.1 and Depth likewise, the rim of the table among them."""
    from diffraction_shader.addon.versions import EEVEE

    def render(count):
        scene = bpy.context.scene
        scene.render.engine = EEVEE
        scene.eevee.taa_render_samples = 1
        return scenes.render(count, centred=True)

    image, truth, good = painted_and_truth(*foil, "NODES", 24, render)
    assert good.sum() > 120
    errors = np.abs(image - truth).sum(-1)[good] / truth.sum(-1)[good]
    print("EEVEE against numpy, percentiles 50, 90, 98:", np.percentile(errors, (50, 90, 98)))
    assert_images_agree(image, truth, 0.02, 97.0, where=good, name="painted_EEVEE")


def furnace(path, implementation, wr, scale, depth, samples, **settings):
    white_world()
    plane = scenes.add_plane(half=1.0)
    scenes.add_camera(wr, extent=0.2)
    made = materials.diffracting(plane, path, implementation, fresnel="NONE", **settings)
    node_of(made).inputs["Scale"].default_value, node_of(made).inputs["Depth"].default_value = scale, depth
    return scenes.render(32, samples)


@pytest.mark.parametrize(("scale", "depth", "theta"), [(0.6, 0.7, 20), (0.8, 1.0, 60), (1.2, 0.9, 40), (0.8, 0.09, 20)])
@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_a_white_furnace_equals_the_quadrature(blender, foil, implementation, scale, depth, theta):
    table, path = foil
    wr = direction(theta, 53)
    image = furnace(path, implementation, wr, scale, depth, 144)
    wi, cell = hemisphere(800)
    xyz = (radiance.f_cos_xyz(ScaledTable(table, scale, depth), wi, wr) * cell[..., None]).sum((0, 1))
    assert (image @ luminance_row()).mean() == pytest.approx(xyz[1], rel=0.015)
    rendered = np.linalg.solve(xyz_to_rgb_matrix(), image.mean((0, 1)))
    assert (rendered / table.info["colour"]["white_xyz"] <= 1.01).all()


@pytest.mark.slow
@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_a_lamp_in_a_world_counts_once_on_a_stretched_surface(blender, foil, implementation):
    """Both directions that one is taken of are left to the lamp where they meet it: lamp and world apart add up."""
    _, path = foil
    found = {}
    for name in ("lamp", "world", "both"):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.context.scene.render.engine, bpy.context.scene.cycles.shading_system = "CYCLES", True
        if name != "lamp":
            white_world()
        plane = scenes.add_plane(half=1.0)
        if name != "world":
            add_lamp("AREA", (0.5, 0.9, 2.0), energy=4500.0, shape="DISK", size=0.9)
        scenes.add_camera((0.1, 0.2, 1.0), extent=0.2)
        made = materials.diffracting(plane, path, implementation, fresnel="NONE")
        node_of(made).inputs["Scale"].default_value = 0.7
        found[name] = scenes.render(16, 144).mean((0, 1))
    assert found["lamp"].min() > 0.1
    assert found["both"] == pytest.approx(found["lamp"] + found["world"], rel=0.02)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_raw_model_in_a_furnace_equals_the_quadrature(blender, foil, implementation):
    table, path = foil
    wr = direction(30, 53)
    image = furnace(path, implementation, wr, 0.7, 0.8, 400, conserve_energy=False)
    wi, cell = hemisphere(800)
    scaled = ScaledTable(table, 0.7, 0.8)
    xyz = (radiance.f_cos_xyz(scaled, wi, wr, conserve=False) * cell[..., None]).sum((0, 1))
    assert (image @ luminance_row()).mean() == pytest.approx(xyz[1], rel=0.03)


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_a_stack_inside_is_corrected_to_the_true_half_angle(blender, tmp_path, implementation):
    path = tmp_path / "film.exr"
    stack = parse_stack("al", ["1.46:500"])
    parameters = BakeParameters(sigma_s_m=1.5e-6, detail=0.4, stack=stack)
    bake(make_preset("sinusoid", 20e-6, 230, period_um=1.6, amplitude_nm=60.0), parameters).save(path)
    table = SpectralTable.load(path)
    sphere = scenes.add_sphere(segments=512, rings=256)
    scenes.add_sun(SUN)
    scenes.add_camera((0.2, 0.1, 1.0))
    made = materials.diffracting(sphere, path, implementation, environment=0)
    node_of(made).inputs["Scale"].default_value, node_of(made).inputs["Depth"].default_value = 0.8, 0.6
    truth, good = expected(sphere, ScaledTable(table, 0.8, 0.6), [SUN], 32)
    assert_images_agree(scenes.render(32), truth, 0.01, 98, where=good, name=f"stack_{implementation}")


def dominant_wavelengths(xyz):
    """By colour-science, metres: another way than that of the recipe."""
    import colour

    white = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"]["D65"]
    return np.array([float(colour.dominant_wavelength(each, white)[0]) for each in colour.XYZ_to_xy(xyz)]) * 1e-9


@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_a_painted_picture_is_rendered_in_its_own_hues(blender, tmp_path, implementation):
    """A card under the sun of its recipe: dominant wavelengths within 10 nm, what cannot be shown is dark."""
    from diffraction_shader.addon.materials.node import paint_nodes

    from precompute.paint import make_paint, save_paint

    path, lamp = tmp_path / "grating.exr", 35.0
    field = make_preset("sinusoid", 48e-6, 640, period_um=1.6, amplitude_nm=25)
    bake(field, BakeParameters(sigma_s_m=5e-6, level="none")).save(path)
    lines = np.array([400, 460, 475, 490, 510, 530, 550, 570, 590, 605, 620, 690]) * 1e-9
    grid, weights = spectral_weights(illuminant="E")
    xyz = np.stack([np.interp(lines, grid, weights[:, i]) for i in range(3)], -1)
    rgb = xyz @ xyz_to_rgb_matrix().T
    rgb -= np.minimum(rgb.min(-1, keepdims=True), 0.0)  # towards white until it is in the gamut
    rgb /= rgb.max(-1, keepdims=True)
    count = len(lines)
    paint = make_paint(
        "picture", 1.6e-6, pixels=count, pictures=[np.repeat(rgb[None], count, 0)], lamp_deg=lamp, sigma_s_um=5.0
    )
    plane = scenes.add_plane(half=1.0)
    made = materials.diffracting(plane, path, implementation, fresnel="NONE", environment=0)
    paint_nodes.wire(made, paint_nodes.load(save_paint(paint, tmp_path / "paint.exr")))
    scenes.add_sun((np.sin(np.radians(lamp)), 0.0, np.cos(np.radians(lamp))))
    scenes.add_camera((0.0, 0.0, 1.0), extent=2.0)
    image = scenes.render(4 * count, 4)[::-1, ::-1]
    columns = image.reshape(4 * count, count, 4, 3)[: 2 * count, :, 1:3].mean((0, 2))
    shown = paint.mask.mean(0) > 0.5
    assert 8 <= shown.sum() < count  # the ends of the spectrum are marked
    luminances = columns @ luminance_row()
    assert luminances[~shown].max() < 0.05 * luminances[shown].min()
    seen, wanted = (dominant_wavelengths(each @ np.linalg.inv(xyz_to_rgb_matrix()).T) for each in (columns, rgb))
    off = np.abs(seen - wanted)[shown]
    print(f"{implementation}: {shown.sum()} hues, at most {1e9 * off.max():.1f} nm off, mean {1e9 * off.mean():.1f} nm")
    assert off.max() < 10e-9
