# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise of the environment as Cycles renders it: how much, without structure, fresh in each frame, denoisable."""

import bpy
import numpy as np
import pytest

from precompute.light.colour import luminance_row
from tests.support.blender import extension, materials, scenes, tables
from tests.support.blender.worlds import white_world
from tests.truth import radiance
from tests.truth.hemisphere import direction, hemisphere, ideal_spread


def gradient(wi):
    """Radiance of `gradient_world`."""
    return 1.2 + wi[..., 0]


def gradient_world():
    """Bright towards +x, dark towards -x."""
    world = white_world()
    nodes, links = world.node_tree.nodes, world.node_tree.links
    place, split, add = (nodes.new(f"ShaderNode{name}") for name in ("TexCoord", "SeparateXYZ", "Math"))
    add.inputs[1].default_value = 1.2
    links.new(place.outputs["Generated"], split.inputs[0])
    links.new(split.outputs["X"], add.inputs[0])
    links.new(add.outputs[0], nodes["Background"].inputs["Strength"])


def sun_behind_haze(wi):
    """Radiance of `picture_world`: a bright patch of about 12 degrees in a dim sky."""
    return 0.2 + 20.0 * np.exp((wi @ direction(35, -40) - 1.0) / 0.01)


def picture_world(light, height=256):
    """An environment picture (equirectangular, float) of a radiance."""
    phi = (0.5 - (np.arange(2 * height) + 0.5) / (2 * height)) * 2 * np.pi
    z = np.sin(((np.arange(height) + 0.5) / height - 0.5) * np.pi)
    phi, z = np.meshgrid(phi, z)
    r = np.sqrt(1 - z**2)
    image = bpy.data.images.new("sky", 2 * height, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    values = light(np.stack([r * np.cos(phi), r * np.sin(phi), z], -1))
    pixels = np.stack([values, values, values, np.ones_like(values)], -1).astype(np.float32)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    world = white_world()
    picture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    picture.image = image
    world.node_tree.links.new(picture.outputs["Color"], world.node_tree.nodes["Background"].inputs["Color"])


def plane_seen_from(wr, path, **settings):
    """A plane that an orthographic camera sees under one angle: all pixels have the same expectation."""
    plane = scenes.add_plane(half=1.0)
    scenes.add_camera(wr, extent=0.1)
    return materials.diffracting(plane, path, fresnel="NONE", **settings)


def noise_against_the_ideal(table, wr, light, size=48):
    """Spread of the pixels at 64 samples over the ideal sampler's, and their mean over the truth."""
    luminance = scenes.render(size, samples=64) @ luminance_row()
    mean, spread = ideal_spread(table, wr, light)
    return luminance.std() / mean / (spread / 8), luminance.mean() / mean


@pytest.mark.parametrize("view", [(0, 0), (40, 53), (60, 53)])
def test_noise_of_a_gradient_sky_is_close_to_the_ideal(blender, snake, view):
    """At 64 samples at most 1.5 times that of directions drawn in proportion to f cos; mean within 1 percent."""
    table, path = snake
    gradient_world()
    wr = direction(*view)
    plane_seen_from(wr, path)
    noise, mean = noise_against_the_ideal(table, wr, gradient)
    assert noise < 1.5
    assert mean == pytest.approx(1, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("phi", [0, 11, 171, 240, 299])
@pytest.mark.parametrize("theta", [20, 40, 60])
def test_noise_of_a_gradient_sky_from_all_sides(blender, snake, theta, phi):
    """The extra noise stays below 0.45 of the mean per sample, also where the ideal sampler has next to none."""
    table, path = snake
    gradient_world()
    wr = direction(theta, phi)
    plane_seen_from(wr, path)
    noise, mean = noise_against_the_ideal(table, wr, gradient)
    _, spread = ideal_spread(table, wr, gradient)
    assert noise < max(1.5, np.sqrt(1 + (0.45 / spread) ** 2))
    assert mean == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("view", [(45, 130), pytest.param((0, 0), marks=pytest.mark.slow)])
def test_picture_of_a_sky_with_a_bright_patch_is_unbiased(blender, snake, view):
    table, path = snake
    picture_world(sun_behind_haze)
    wr = direction(*view)
    plane_seen_from(wr, path)
    luminance = scenes.render(64, samples=256) @ luminance_row()
    wi, cell = hemisphere(1500)
    expected = (radiance.f_cos_xyz(table, wi, wr)[..., 1] * cell * sun_behind_haze(wi)).sum()
    assert luminance.std() / 64 / expected < 0.0035  # enough samples to tell
    assert luminance.mean() / expected == pytest.approx(1, abs=0.01)


def structure(image):
    """How far the noise of a picture is from white, 1 = as white noise at the limit that one in thousands passes.

    The largest correlation between neighbours in units of 4.5 standard deviations, and the largest line of the power
    spectrum, which is exponential for white noise, in units of the one that stands out of all frequencies by chance.
    """
    size = image.shape[0]
    y, x = np.mgrid[:size, :size] / size
    smooth = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], -1).reshape(-1, 6)
    noise = image - (smooth @ np.linalg.lstsq(smooth, image.ravel(), rcond=None)[0]).reshape(size, size)
    noise = noise / noise.std()
    shifts = [(0, 1), (1, 0), (1, 1), (1, -1), (0, 2), (2, 0), (0, 3), (3, 0)]
    between = max(abs((noise * np.roll(noise, shift, (0, 1))).mean()) for shift in shifts)
    spectrum = np.abs(np.fft.fft2(noise)) ** 2 / noise.size
    return max(between / (4.5 / size), spectrum.max() / (np.log(noise.size) + 9.0))


@pytest.fixture
def far_away(blender, tmp_path):
    """Makes a plane and a camera a thousand units from the origin and returns the material."""

    def make(kind, distance):
        white_world()
        tables.make_table(tmp_path / "t.exr", tables.gentle)
        plane = scenes.add_plane(half=1.0)
        camera = scenes.add_camera((0.2, 0.1, 1.0), extent=0.5, distance=distance)
        if kind == "PERSP":
            camera.data.type, camera.data.angle = "PERSP", 2 * np.arctan(0.25 / distance)
        if distance < 1000:
            for ob in (plane, camera):
                ob.location.x += 1000.0
        return materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE")

    return make


@pytest.mark.parametrize(("kind", "distance"), [("ORTHO", 10.0), ("PERSP", 10.0), ("ORTHO", 1000.0), ("PERSP", 1000.0)])
def test_noise_is_white_a_thousand_units_away(far_away, kind, distance):
    """Neither a camera and a surface far from the origin nor one that looks from far away leaves patterns."""
    far_away(kind, distance)
    assert structure(scenes.render(64, samples=4)[..., 1]) < 1


@pytest.mark.parametrize("broken", ["I", "floor(40.0 * transform(P))"])
def test_a_broken_hash_would_be_seen(far_away, monkeypatch, broken):
    """The measure finds random numbers that come from the ray's direction, or from too coarse a place."""
    extension.load()
    from diffraction_shader.addon.materials import osl

    source, place = osl.source, 'noise("hash", transform("object", P), 17.0)'
    broken = broken.replace("transform(P)", 'transform("object", P)')

    def with_broken_hash(*arguments, **options):
        text = source(*arguments, **options)
        assert place in text
        return text.replace(place, f'noise("hash", {broken}, 17.0)')

    monkeypatch.setattr(osl, "source", with_broken_hash)
    far_away("ORTHO" if broken == "I" else "PERSP", 10.0)
    image = scenes.render(64, samples=4)[..., 1]
    assert image.std() < 1e-4 * image.mean() or structure(image) > 3


def test_another_frame_has_fresh_noise_and_the_same_mean(blender, snake):
    """With an animated seed, and with a surface that moves under a fixed seed.

    Cycles puts the first sample of a pixel into its middle whatever the seed: one of N places stays.
    """
    _, path = snake
    gradient_world()
    plane_seen_from(direction(40, 53), path)
    scene, samples, size = bpy.context.scene, 16, 64
    scene.cycles.use_animated_seed = True
    pictures = []
    for frame, x in ((1, 0.0), (2, 0.0), (2, 0.05), (2, 0.13)):
        scene.frame_set(frame)
        bpy.data.objects["plane"].location.x = x
        pictures.append(scenes.render(size, samples) @ luminance_row())
    means = np.array([picture.mean() for picture in pictures])
    assert np.abs(means - means.mean()).max() < 4.5 * pictures[0].std() / size
    shared = np.corrcoef([picture.ravel() for picture in pictures])
    assert abs(shared[0, 1]) < 2 / samples + 4.5 / size
    assert np.abs(shared[np.triu_indices(4, 1)][1:]).max() < 4.5 / size


@pytest.mark.slow
def test_denoised_pictures_are_better_stable_and_unbiased(blender, snake):
    """A sphere under a gradient sky at 16 samples, OpenImageDenoise, against many samples and another seed."""
    _, path = snake
    gradient_world()
    sphere = scenes.add_sphere(segments=128, rings=64)
    scenes.add_camera((0.3, -0.8, 0.5))
    materials.diffracting(sphere, path, fresnel="NONE")
    scene = bpy.context.scene
    scene.cycles.max_bounces = 2

    def pictures(denoise):
        found = []
        for seed in (1, 2):
            scene.cycles.seed = seed
            found.append(scenes.render(96, samples=16, denoise=denoise))
        return found

    noisy, clean = pictures(False), pictures(True)
    scene.cycles.seed = 3
    truth = scenes.render(96, samples=400)

    def error(a, b):
        return np.sqrt(((a - b) ** 2).mean())

    for before, after in zip(noisy, clean, strict=True):
        assert error(after, truth) < 0.6 * error(before, truth)
        assert (after @ luminance_row()).mean() == pytest.approx((before @ luminance_row()).mean(), rel=0.01)
    assert error(*clean) < 0.4 * error(*noisy)  # what flickers from frame to frame
