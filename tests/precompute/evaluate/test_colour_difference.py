# SPDX-License-Identifier: GPL-3.0-or-later
"""Delta E 2000: known pairs, and the methods beside each other."""

import numpy as np
import pytest

from precompute.bake.baking import bake
from precompute.errors import ParameterError
from precompute.evaluate.colour_difference import delta_e_2000
from precompute.evaluate.direct import direct_xyz
from precompute.evaluate.directions import disc_directions, from_angles
from precompute.evaluate.disc_map import exposure_of
from precompute.evaluate.methods import make_method
from precompute.evaluate.methods.flss import method_xyz
from precompute.evaluate.surface import brdf
from precompute.light.colour import white_xyz
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan.levelling import level


def xyz_of(lab):
    """XYZ of CIE L*a*b* relative to the white, by the definition (CIE 15:2018, 8.2.1)."""
    L, a, b = lab
    f = np.array([(L + 16) / 116 + a / 500, (L + 16) / 116, (L + 16) / 116 - b / 200])
    return white_xyz() * np.where(f > 6 / 29, f**3, 3 * (6 / 29) ** 2 * (f - 4 / 29))


@pytest.mark.parametrize(
    ("one", "other", "difference"),
    [
        # Sharma, Wu and Dalal, Color Res. Appl. 30 (2005) 21, table 1: pairs 1, 7, 17, 25, 33.
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, 0, 0), (50, -1, 2), 2.3669),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
        ((6.7747, -0.2908, -2.4247), (5.8714, -0.0985, -2.2286), 0.6377),
    ],
)
def test_published_pairs(one, other, difference):
    # Chromatic adaptation plays no part: Lab is relative to the illuminant's own white.
    found = delta_e_2000(xyz_of(one), xyz_of(other), exposure=1.0)
    assert found == pytest.approx(difference, abs=2e-3)


def test_what_is_brighter_than_white_differs_by_chromaticity_only():
    white = white_xyz()
    assert delta_e_2000(5 * white, 9 * white, exposure=1.0) == pytest.approx(0.0, abs=1e-9)
    assert delta_e_2000(5 * white * [1.1, 1, 1], 9 * white, exposure=1.0) > 5


def test_shapes_must_match():
    with pytest.raises(ParameterError):
        delta_e_2000(np.ones((4, 3)), np.ones((5, 3)))


def test_methods_agree_on_the_snake():
    """Untruncated `windowed`, the table and direct summation look the same: Delta E 2000 below 1 in the median."""
    field = level(make_preset("snake", size_m=10e-6, pixels=128), "plane")
    sigma = 1e-6
    wi = from_angles(np.radians(20.0), np.radians(30.0))
    table = bake(field, BakeParameters(sigma_s_m=sigma, ensemble="single"))
    directions, inside = disc_directions(96)
    whole = brdf(table, wi, directions[inside])
    exposure = exposure_of(whole)
    # Every direction on the disc may be drawn; those where the map is black by sheer distance say nothing.
    seen = np.nonzero(exposure * whole[:, 1] > 1e-3)[0]
    chosen = np.random.default_rng(5).choice(seen, 30, replace=False)
    wr = directions[inside][chosen]
    reference = direct_xyz(field, sigma, "single", wi, wr)
    windowed = method_xyz(make_method("windowed", field, sigma), wi, wr, step_m=2.5e-9)
    for name, values in (("windowed", windowed), ("table", whole[chosen])):
        difference = delta_e_2000(values, reference, exposure)
        assert np.median(difference) < 1.0, (name, np.percentile(difference, [50, 90, 100]))
    assert np.median(delta_e_2000(windowed, reference, exposure)) < 0.05
