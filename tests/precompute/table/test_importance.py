# SPDX-License-Identifier: GPL-3.0-or-later
"""Densities for the environment: they are densities, they follow f cos of every view, and the mean comes out right."""

import functools

import numpy as np
import pytest

from precompute.evaluate.scaled import ScaledTable
from precompute.table import importance as module
from precompute.table.importance import albedo_free_cosine, importance, read_origin, save_importance
from tests.support.blender import tables
from tests.truth import radiance
from tests.truth.hemisphere import around_the_mirror, direction, hemisphere, ideal_spread

VIEWS = [(0, 0), (17, 11), (40, 53), (40, 200), (60, 171), (75, 300)]


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    return tables.make_table(tmp_path_factory.mktemp("lobes") / "t.exr", tables.lobes)


@pytest.fixture(scope="module")
def found(table):
    return importance(table)


def drawn(found, wr, count, seed=0):
    rng = np.random.default_rng(seed)
    return found.draw(np.asarray(wr), rng.random(count), rng.random(count))


def sky(wi):
    """Bright on one side, dark on the other."""
    return 1.2 + wi[..., 0]


def patch(wi):
    """A small bright patch in a dim sky."""
    axis = direction(25, -40)
    return 0.1 + 30.0 * (wi @ axis > np.cos(0.15))


@pytest.mark.parametrize("view", VIEWS)
def test_density_integrates_known_functions(found, view):
    """The mean of g / p is the integral of g over the hemisphere: 2 pi of 1, pi of cos, 0 of x."""
    wi, gain = drawn(found, direction(*view), 400_000)
    assert np.allclose((wi**2).sum(-1), 1, atol=1e-12)
    assert (wi[:, 2] > 0).all()
    inner = wi[:, 2] > 0.1
    for g, expected in ((1.0, 2 * np.pi * 0.9), (wi[:, 2], np.pi * 0.99), (wi[:, 0] + 0.5, np.pi * 0.9)):
        value = inner * g * gain
        assert value.mean() == pytest.approx(expected, abs=5 * value.std() / np.sqrt(len(wi)) + 1e-3)


def test_directions_gather_where_f_is_bright(table, found):
    """The part of all directions that falls into a lobe is the lobe's part of the light."""
    wr = np.array((0.0, 0.0, 1.0))  # a stored view
    wi, _ = drawn(found, wr, 50_000)
    around, cell = around_the_mirror(wr)
    light = radiance.f_cos_xyz(table, around, wr)[:, 1] * cell

    def near(directions, u, v):
        return np.hypot(*(-(directions + wr)[:, :2] - (u, v)).T) < 0.2

    parts = []
    for u, v in ((-0.1, 0.6), (0.5, 0.1), (0.0, 0.0), (0.1, -0.6)):
        parts.append((light * near(around, u, v)).sum() / light.sum())
        assert near(wi, u, v).mean() == pytest.approx(parts[-1], rel=0.15)  # not luminance alone
    assert parts[0] > 2 * parts[-1]


@pytest.mark.parametrize("view", VIEWS)
def test_albedo_by_drawing_equals_quadrature(table, found, view):
    wr = direction(*view)
    wi, gain = drawn(found, wr, 200_000)
    weights = radiance.f_cos_xyz(table, wi, wr) * gain[:, None]
    angle, turn = np.meshgrid((np.arange(300) + 0.5) / 300 * np.pi / 2, (np.arange(300) + 0.5) / 300 * 2 * np.pi)
    around = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], -1)
    cell = np.sin(angle) * (np.pi / 2 / 300) * (2 * np.pi / 300)
    expected = (radiance.f_cos_xyz(table, around, wr) * cell[..., None]).sum((0, 1))
    error = weights.std(0) / np.sqrt(len(wi))
    assert (np.abs(weights.mean(0) - expected) < 5 * error + 0.002 * expected).all()
    assert (error < 0.003 * expected).all()


@functools.cache
def preset(name):
    """A preset's table, small, and its densities."""
    from precompute.bake.baking import bake
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    table = bake(make_preset(name, 40e-6, 640 if name == "snake" else 440), BakeParameters(sigma_s_m=3e-6, detail=0.7))
    return table, importance(table)


@pytest.mark.parametrize(
    ("name", "theta"),
    [("snake", 0), ("snake", 40), ("blazed", 40)]
    + [pytest.param(name, theta, marks=pytest.mark.slow) for name in ("snake", "cd") for theta in (20, 60)]
    + [pytest.param("cd", 40, marks=pytest.mark.slow), pytest.param("blazed", 20, marks=pytest.mark.slow)],
)
def test_spread_of_a_sample_is_close_to_the_ideal(name, theta):
    """Sky with a gradient, and a bright patch: at most 1.5 times the spread of the ideal sampler over azimuths.

    Where the viewer sees the middle of the gradient the ideal's own spread vanishes, and any sampler is infinitely
    worse; so the bound holds for the mean over azimuths. The light of the blazed grating is one blue order, whose
    colour a density of luminance alone would serve badly: there the spread of the weights itself is bounded.
    """
    table, found = preset(name)
    ours, ideal = [], []
    for phi in (0, 50, 171, 299) if theta else (0,):
        wr = direction(theta, phi)
        wi, gain = drawn(found, wr, 40_000)
        weight = radiance.f_cos_xyz(table, wi, wr)[:, 1] * gain
        assert weight.std() < (0.7 if name == "blazed" else 0.4) * weight.mean()  # even directions: 5 to 30
        assert weight.max() < 80 * weight.mean()
        for light in (sky, patch):
            mean, spread = ideal_spread(table, wr, light)
            value = weight * light(wi)
            assert value.mean() == pytest.approx(mean, abs=5 * value.std() / np.sqrt(len(wi)) + 0.01 * mean)
            ours.append(value.std() / mean)
            ideal.append(spread)
    ours, ideal = np.reshape(ours, (-1, 2)), np.reshape(ideal, (-1, 2))
    assert name == "blazed" or (np.sqrt((ours**2).mean(0) / (ideal**2).mean(0)) < 1.5).all()


def test_albedo_free_cosine_bounds_the_albedo(tmp_path):
    """Above the cosine no albedo passes 1; where none does at all there is nothing to look up."""
    low = tables.make_table(tmp_path / "low.exr", tables.lobes)
    high = tables.make_table(tmp_path / "high.exr", tables.lobes, albedo=lambda theta, phi: 0.6 / np.cos(0.99 * theta))
    always = tables.make_table(tmp_path / "all.exr", tables.lobes, albedo=lambda theta, phi: 1.1 + 0 * theta)
    assert albedo_free_cosine(low) == 0.0
    assert albedo_free_cosine(always) > 1.0
    limit = albedo_free_cosine(high)
    assert np.cos(np.arccos(0.6) / 0.99) < limit < 0.8  # a step of the table's grid above the truth at most
    theta = np.linspace(0.0, np.arccos(limit), 200)
    wi = np.stack([np.sin(theta), np.zeros_like(theta), np.cos(theta)], -1)
    assert (high.albedo(wi) <= 1.0).all()


def test_image_keeps_the_edges_and_its_origin(found, tmp_path):
    import OpenEXR

    image = found.image()
    path = tmp_path / "i.exr"
    assert read_origin(path) is None
    save_importance(image, path, "abc", 0.7)
    assert read_origin(path) == ("abc", 0.7)
    with OpenEXR.File(str(path)) as file:
        pixels = file.channels()["RGB"].pixels[::-1]
    n_r, n_phi = module.N_R, module.N_PHI
    assert np.array_equal(pixels[3, :n_r, :2], found.radius[3])
    assert np.array_equal(pixels[5, n_r + 7 * n_phi :][:n_phi], found.turn[5, 7])
    assert (found.radius[:, 1:, 0] == found.radius[:, :-1, 1]).all()  # no gap, no overlap
    assert (found.turn[:, :, 1:, 0] == found.turn[:, :, :-1, 1]).all()
    used = np.zeros(found.turn.shape[:2], bool)
    used[np.arange(module.VIEWS)[:, None], found.row] = True
    low, high, middle = np.moveaxis(found.turn[used], -1, 0)
    assert (low < middle).all()
    assert (middle < high).all()
    assert (low[:, 0] == 0).all()
    assert (high[:, -1] == 1).all()
    assert np.allclose(pixels[400, -module.CUTS :, 1], found.cuts()[400])
    assert path.stat().st_size < 20e6
    path.write_bytes(path.read_bytes()[:-4000])  # a copy that was broken off is made anew
    assert read_origin(path) is None


def test_image_of_an_older_version_is_not_taken(found, tmp_path, monkeypatch):
    monkeypatch.setattr(module, "VERSION", module.VERSION.replace("2 ", "1 ", 1))
    save_importance(found.image(), tmp_path / "i.exr", "abc", 0.7)
    monkeypatch.undo()
    assert read_origin(tmp_path / "i.exr") is None


@pytest.mark.parametrize("view", [(0, 0), (50, 100)])
@pytest.mark.parametrize(("scale", "depth"), [(0.8, 0.9), (0.5, 1.0), (1.3, 0.8)])
def test_directions_on_a_scaled_surface_give_its_mean(table, found, view, scale, depth):
    """The mean of f cos over the density is the integral over the hemisphere, whatever the density throws away."""
    scaled, wr = ScaledTable(table, scale, depth), direction(*view)
    random = np.random.default_rng(4)
    wi, gain = found.draw_scaled(wr, *random.random((2, 60000)), scale, depth)
    weights = radiance.f_cos_xyz(scaled, wi, wr)[:, 1] * gain
    directions, cell = hemisphere(500)
    truth = (radiance.f_cos_xyz(scaled, directions, wr)[..., 1] * cell).sum()
    assert weights.mean() == pytest.approx(truth, abs=max(0.015 * truth, 4.5 * weights.std() / np.sqrt(weights.size)))


@pytest.mark.parametrize(
    ("name", "scale", "depth", "bound"),
    [
        ("snake", 1.0, 0.8, 1.3), ("snake", 1.0, 0.4, 1.3), ("snake", 0.5, 0.5, 1.3), ("snake", 0.8, 1.0, 1.4),
        ("blazed", 1.0, 0.4, 1.6),
    ],
)  # fmt: skip
def test_noise_of_a_scaled_surface_is_near_that_of_the_plain_one(name, scale, depth, bound):
    """Relative spread of a sample over that at 1, root mean square of four views (without sets of views: up to 15).

    Stretched surfaces take one of two directions, as ``shaders/diffraction.osl`` does.
    """
    table, found = preset(name)

    def spread(s, q, wr):
        xi = np.random.default_rng(3).random((3, 30_000))
        weights, light = [], []
        for shift in (0.0, 0.5) if s < 0.95 else (0.0,):
            wi, gain = found.draw_scaled(wr, *np.mod(xi[:2] + shift, 1.0), s, q)
            lit = gain > 0.0
            weights.append(np.zeros(len(gain)))
            weights[-1][lit] = radiance.f_cos_xyz(ScaledTable(table, s, q), wi[lit], wr)[:, 1] * gain[lit]
            light.append(sky(wi))
        both = sum(weights)
        value = both / len(weights) * np.where(xi[2] * both < weights[-1], light[-1], light[0])
        return value.std() / value.mean()

    ratios = [spread(scale, depth, wr) / spread(1.0, 1.0, wr) for wr in (direction(*v) for v in VIEWS[:4])]
    noise = float(np.sqrt(np.mean(np.square(ratios))))
    print(f"{name} at {scale:g}, {depth:g}: noise {noise:.2f} times that at 1")
    assert noise < bound
