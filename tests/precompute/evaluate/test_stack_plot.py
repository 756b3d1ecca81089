# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of R over wavelength and angle shows R."""

import numpy as np
import pytest

from precompute.evaluate.stack_plot import stack_plot
from precompute.stack import material_of, parse_stack


@pytest.mark.parametrize(
    ("substrate", "films", "outer"), [("Au", ["1.46:250"], None), ("1.5", [], "PMMA"), ("Cu", [], None)]
)
def test_grey_is_r(substrate, films, outer):
    stack, outside = parse_stack(substrate, films), None if outer is None else material_of(outer)
    picture, least, largest = stack_plot(stack, outside, 213, 133)
    assert picture.shape == (133, 213, 3)
    assert (picture >= 0).all() and (picture <= 1).all()
    lam, angle = 380e-9 + 400e-9 * (np.array([20, 130]) + 0.5) / 200, np.pi / 2 * (np.array([10, 60, 100]) + 0.5) / 120
    r = stack.reflectance(lam, np.cos(angle), outside).T / largest
    grey = picture[13:][[10, 60, 100]][:, [20, 130]]
    srgb = np.where(r > 0.0031308, 1.055 * r ** (1 / 2.4) - 0.055, 12.92 * r)
    assert grey == pytest.approx(np.repeat(srgb[..., None], 3, -1), abs=1e-6)
    assert least <= (r * largest).min() and largest <= 1.0


def test_strips_are_colours():
    picture, _, _ = stack_plot(parse_stack("Au"))
    blue, red = picture[4, 35], picture[4, 130]  # about 450 and 660 nm
    assert blue[2] > blue[1] and red[0] > 0.9 and red[1] < 0.3
    gold = picture[20, -4]
    assert gold[0] > gold[1] > gold[2]
