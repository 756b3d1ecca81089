# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps as pictures: where things lie, what a display shows, the grid."""

from __future__ import annotations

import numpy as np
import pytest

from precompute.errors import OutputError, ParameterError
from precompute.evaluate.disc_map import brdf_map, direction_grid, exposure_of, map_to_srgb, save_map
from precompute.light.colour import white_xyz


class Mirror:
    """White light in the mirror direction only: a narrow lobe round u = v = 0."""

    def transform(self, u, v, w):
        return np.exp(-(u**2 + v**2) / 0.005)[..., None] * white_xyz()

    def albedo(self, directions):
        return np.ones(directions.shape[:-1])


@pytest.mark.parametrize("light", [(0.5, 0.0), (0.0, 0.6), (-0.3, 0.4)])
def test_peak_lies_opposite_the_light(light):
    """Light from the right: the peak is on the left; row 0 is the bottom."""
    x, y = light
    xyz = brdf_map(Mirror(), np.array([x, y, np.sqrt(1 - x * x - y * y)]), 101)
    row, col = np.unravel_index(xyz[..., 1].argmax(), (101, 101))
    assert ((col + 0.5) / 50.5 - 1, (row + 0.5) / 50.5 - 1) == pytest.approx((-x, -y), abs=0.03)


def test_outside_the_disc_is_black():
    xyz = brdf_map(Mirror(), np.array([0.0, 0.0, 1.0]), 64)
    assert not xyz[0, 0].any()
    assert not map_to_srgb(xyz)[-1, -1].any()


def test_exposure_shows_two_percent_at_full_brightness_and_keeps_white_white():
    xyz = np.linspace(0, 10, 5001)[1:, None] * white_xyz()
    shown = map_to_srgb(xyz[None], exposure_of(xyz))[0]
    assert (shown.max(axis=-1) >= 1 - 1e-9).mean() == pytest.approx(0.02, abs=1e-3)
    assert np.allclose(shown, shown[:, :1], atol=1e-6)
    assert exposure_of(np.zeros((4, 3))) == 1.0


def test_grid_has_circles_and_spokes():
    grid = direction_grid(400)
    assert grid.min() == 0
    assert grid.max() <= 1
    for radius in (0.5, np.sin(np.radians(60))):  # off the spokes: azimuth 15 degrees
        angle = np.radians(15)
        near = [200 + r * 200 * np.array([np.cos(angle), np.sin(angle)]) for r in (radius, 0.95 * radius)]
        on, off = (grid[int(p[1]) - 1 : int(p[1]) + 2, int(p[0]) - 1 : int(p[0]) + 2].max() for p in near)
        assert on > 0.5
        assert off == 0
    assert grid[200, 350] > 0.4  # azimuth 0


def test_grid_is_drawn_over_a_png(tmp_path):
    from PIL import Image

    xyz = brdf_map(Mirror(), np.array([0.5, 0.0, np.sqrt(0.75)]), 64)
    shown = {}
    for grid in (False, True):
        with Image.open(save_map(xyz, tmp_path / "map.png", grid=grid)) as image:
            shown[grid] = np.asarray(image, float).sum()
    assert shown[True] > 1.2 * shown[False]


def test_bad_input_is_refused(tmp_path):
    with pytest.raises(ParameterError):
        brdf_map(Mirror(), np.array([0.0, 0.0, 1.0]), 1)
    with pytest.raises(OutputError):
        save_map(np.zeros((4, 4, 3)), tmp_path / "map.jpg")
