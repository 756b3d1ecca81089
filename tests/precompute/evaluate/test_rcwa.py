# SPDX-License-Identifier: GPL-3.0-or-later
"""The scalar model beside Maxwell's equations, and the numbers that docs/rcwa.md states."""

import numpy as np
import pytest

from tests.truth.rigorous import ALUMINIUM, KERATIN, TE, TM, coupled_waves, fresnel, orders, sinusoidal, staircase
from tools.docs.fill_page import block
from tools.docs.rcwa_page import (
    ANGLES,
    DEPTHS_NM,
    PAGE,
    PERIODS_UM,
    SIDE_BY_SIDE,
    WAVELENGTH,
    Grating,
    deepest,
    errors,
    side_by_side_rows,
)

POLARISATIONS = pytest.mark.parametrize("polarisation", [TE, TM], ids=["TE", "TM"])


@POLARISATIONS
@pytest.mark.parametrize("index", [KERATIN, ALUMINIUM])
def test_solvers_reflect_as_fresnel_from_a_flat_surface(index, polarisation):
    theta = np.radians(55.0)
    truth = fresnel(index, theta)[polarisation]
    m = orders(1.5e-6, WAVELENGTH, theta)
    for found in (
        coupled_waves(index, np.ones((1, 4), bool), 50e-9, 1.5e-6, WAVELENGTH, theta, polarisation, 8),
        sinusoidal(index, 0.0, 1.5e-6, WAVELENGTH, theta, polarisation, 10),
    ):
        assert found[m == 0] == pytest.approx(truth, rel=1e-5)
        assert np.abs(found[m != 0]).max() < 1e-9


@POLARISATIONS
def test_the_two_solvers_agree_on_a_sinusoid_of_keratin(polarisation):
    theta = np.radians(30.0)
    smooth = sinusoidal(KERATIN, 150e-9, 1.5e-6, WAVELENGTH, theta, polarisation, 15)
    stairs = staircase(KERATIN, 150e-9, 1.5e-6, WAVELENGTH, theta, polarisation, 12, 40)
    # What is left is the staircase: forty steps.
    np.testing.assert_allclose(stairs, smooth, rtol=0.02, atol=1e-5)


def test_a_long_and_shallow_grating_agrees_within_half_a_percent():
    for material in ("keratin", "aluminium"):
        assert errors(Grating(material, "sinusoidal", 5.0, 100), 0).all_light < 0.005


def test_a_deep_sub_wavelength_grating_does_not():
    assert errors(Grating("keratin", "sinusoidal", 0.6, 400), 30).all_light > 0.5


def page_rows(name):
    """Cells of a table of the page, without its head."""
    lines = block(PAGE.read_text(encoding="utf-8"), name).splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


@pytest.mark.parametrize("number", range(len(SIDE_BY_SIDE)))
def test_order_efficiencies_are_those_of_the_page(number):
    grating, angle = SIDE_BY_SIDE[number]
    stated = page_rows("side by side")
    rows = side_by_side_rows(grating, angle)
    first = next(i for i, row in enumerate(stated) if row[0] == rows[0][0])
    for row, on_page in zip(rows, stated[first : first + len(rows)], strict=True):
        assert row[:2] == on_page[:2]
        np.testing.assert_allclose([float(x) for x in row[2:]], [float(x) for x in on_page[2:]], atol=0.003)


@pytest.mark.parametrize(
    ("material", "shape", "angle", "period"),
    [
        ("keratin", "sinusoidal", 0, 1.6),
        ("keratin", "lamellar", 30, 2.5),
        ("aluminium", "sinusoidal", 60, 1.0),
        ("aluminium", "lamellar", 0, 0.6),
    ],
)
def test_limits_are_those_of_the_page(material, shape, angle, period):
    """Up to the stated depth at most 5 % of the light is misplaced, at the next depth it is more."""
    assert angle in ANGLES
    row = next(row for row in page_rows("limits") if row[0] == f"{material}, {shape}, {angle} deg")
    stated = row[1 + PERIODS_UM.index(period)]
    reached = None if stated == "-" else int(stated)
    following = DEPTHS_NM[: (0 if reached is None else DEPTHS_NM.index(reached) + 1) + 1]
    found = {depth: errors(Grating(material, shape, period, depth), angle).all_light for depth in following}
    assert deepest(found) == reached
