# SPDX-License-Identifier: GPL-3.0-or-later
"""Flips and turns move a marked corner where a person expects it."""

import numpy as np
import pytest

from precompute.errors import ParameterError
from precompute.scan.heightfield import HeightField
from precompute.scan.orientation import flip_x, flip_y, rotate90


@pytest.fixture
def field():
    """The tall pixel is at the right end of the bottom row; one point is missing at the top left."""
    heights, missing = np.zeros((3, 4)), np.zeros((3, 4), bool)
    heights[0, -1], missing[-1, 0] = 1.0, True
    return HeightField(heights, 1e-6, 2e-6, missing, {"fast_axis": "x"})


def tall(field):
    row, col = np.argwhere(field.heights == 1.0)[0]
    return ("bottom", "top")[int(row > 0)], ("left", "right")[int(col > 0)]


def test_flips(field):
    assert tall(field) == ("bottom", "right")
    assert tall(flip_x(field)) == ("bottom", "left")
    assert tall(flip_y(field)) == ("top", "right")
    assert flip_x(field).missing[-1, -1]
    assert flip_y(field).missing[0, 0]
    assert [step["step"] for step in flip_y(flip_x(field)).processing] == ["flip x", "flip y"]


def test_quarter_turns_are_anticlockwise(field):
    assert [tall(rotate90(field, turns)) for turns in (1, 2, 3, -1)] == [
        ("top", "right"),
        ("top", "left"),
        ("bottom", "left"),
        ("bottom", "left"),
    ]


def test_a_quarter_turn_exchanges_the_axes(field):
    turned = rotate90(field)
    assert turned.size_m == pytest.approx((6e-6, 4e-6))
    assert (turned.dx, turned.dy) == (2e-6, 1e-6)
    assert turned.metadata["fast_axis"] == "y"
    assert turned.missing[0, 0]


def test_four_turns_change_nothing(field):
    again = rotate90(rotate90(rotate90(rotate90(field))))
    np.testing.assert_array_equal(again.heights, field.heights)
    np.testing.assert_array_equal(again.missing, field.missing)
    assert rotate90(field, 4) is field


def test_half_a_quarter_is_refused(field):
    with pytest.raises(ParameterError, match="whole quarters"):
        rotate90(field, 0.5)
