# SPDX-License-Identifier: GPL-3.0-or-later
"""Densities for the environment: they are densities, they follow the table, and the mean comes out right."""

import numpy as np
import pytest

from precompute.importance import importance, made_from, save_importance
from tests.addon import tables
from tests.truth import radiance


@pytest.fixture
def table(tmp_path):
    return tables.make_table(tmp_path / "t.exr", tables.lobes)


def random_points(found, count, cos_r, seed=0):
    rng = np.random.default_rng(seed)
    return found.draw(np.full(count, cos_r), rng.random(count), rng.random(count))


@pytest.mark.parametrize("cos_r", [0.05, 0.3, 0.7, 0.99])
def test_density_integrates_known_functions(table, cos_r):
    """The mean of g / q is the integral of g over the disc of radius `reach`: here of 1 and of u^2 + v."""
    found = importance(table)
    u, v, q = random_points(found, 400_000, cos_r)
    reach = 1 + np.sqrt(1 - (np.floor(cos_r * 8) / 8) ** 2)
    assert np.hypot(u, v).max() <= reach * (1 + 1e-6)
    inner = np.hypot(u, v) < 0.8
    assert (inner / q).mean() == pytest.approx(np.pi * 0.8**2, rel=0.02)
    assert (inner * (u**2 + v) / q).mean() == pytest.approx(np.pi * 0.8**4 / 4, rel=0.05)


def test_points_gather_where_the_table_is_bright(table):
    u, v, _ = random_points(importance(table), 50_000, 0.9)
    blue = (np.hypot(u + 0.4, v + 0.5) < 0.2).mean()
    dark = (np.hypot(u - 0.4, v + 0.5) < 0.2).mean()
    assert blue > 3 * dark


@pytest.mark.parametrize("theta", [0.0, 0.6, 1.2])
def test_albedo_by_drawing_equals_quadrature(table, theta):
    """Weights f / q over drawn points against a sum over the hemisphere; f has no cosine here, q is per du dv."""
    wr = np.array([np.sin(theta) * 0.8, np.sin(theta) * 0.6, np.cos(theta)])
    u, v, q = random_points(importance(table), 200_000, wr[2])
    xy = -np.stack([u, v], -1) - wr[:2]
    z2 = 1 - (xy**2).sum(-1)
    good = z2 > 1e-9
    wi = np.concatenate([xy, np.sqrt(np.where(good, z2, 1))[:, None]], -1)
    f = radiance.f_cos_xyz(table, wi, wr, conserve=False) / wi[:, 2:]
    drawn = np.where(good[:, None], f, 0.0) / q[:, None]
    angle, turn = np.meshgrid((np.arange(400) + 0.5) / 400 * np.pi / 2, (np.arange(400) + 0.5) / 400 * 2 * np.pi)
    around = np.stack([np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], -1)
    cell = np.sin(angle) * (np.pi / 2 / 400) * (2 * np.pi / 400)
    expected = (radiance.f_cos_xyz(table, around, wr, conserve=False) * cell[..., None]).sum((0, 1))
    error = drawn.std(0) / np.sqrt(len(u))
    assert (np.abs(drawn.mean(0) - expected) < 5 * error + 0.002 * expected).all()
    assert (error < 0.03 * expected).all()  # 1 / cos_i of the raw model makes flat directions rare and heavy


def test_image_keeps_the_edges_and_its_origin(table, tmp_path):
    import OpenEXR

    found = importance(table)
    image = found.image()
    path = tmp_path / "i.exr"
    assert made_from(path) is None
    save_importance(image, path, "abc")
    assert made_from(path) == "abc"
    with OpenEXR.File(str(path)) as file:
        pixels = file.channels()["RGB"].pixels[::-1]
    assert np.array_equal(pixels[3, :128, :2], found.radius[3])
    assert np.array_equal(pixels[8 + 5 * 128 + 7, :128, :2], found.turn[5, 7])
    assert (found.radius[:, 1:, 0] == found.radius[:, :-1, 1]).all()  # no gap, no overlap
    assert (found.turn[:, :, 1:, 0] == found.turn[:, :, :-1, 1]).all()
