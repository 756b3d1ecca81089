# SPDX-License-Identifier: GPL-3.0-or-later
"""The scalar model beside Maxwell's equations, and the numbers that docs/rcwa.md states."""

import numpy as np
import pytest

from tests.truth.rigorous import ALUMINIUM, KERATIN, TE, TM, coupled_waves, fresnel, orders, sinusoidal, staircase
from tools.docs import rcwa_more
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


def test_a_flat_film_in_the_coordinate_transformation_is_the_transfer_matrix():
    from precompute.stack import parse_stack

    theta = np.radians(35.0)
    m = orders(1.5e-6, WAVELENGTH, theta)
    for index, typed in ((ALUMINIUM, rcwa_more.ALUMINIUM_TYPED), (KERATIN, "1.55")):
        found = [sinusoidal(index, 0.0, 1.5e-6, WAVELENGTH, theta, p, 8, (1.46, 130e-9)) for p in (TE, TM)]
        stack = parse_stack(typed, ["1.46:130"])
        truth = stack.reflectance(np.array([WAVELENGTH]), np.array([np.cos(theta)]))[0, 0]
        assert np.mean([values[m == 0] for values in found]) == pytest.approx(truth, rel=1e-6)


def test_energy_is_kept_by_a_film_on_a_relief_without_losses():
    """A film of the substrate's own index is the bare relief."""
    theta = np.radians(25.0)
    for p in (TE, TM):
        bare = sinusoidal(ALUMINIUM, 100e-9, 1.5e-6, WAVELENGTH, theta, p, 15)
        like_air = sinusoidal(ALUMINIUM, 100e-9, 1.5e-6, WAVELENGTH, theta, p, 15, (1.0, 90e-9))
        np.testing.assert_allclose(like_air, bare, rtol=1e-4, atol=1e-6)


def numbers_of(name, row):
    return [float(cell) for cell in page_rows(name)[row][1:]]


@pytest.mark.parametrize(("row", "period", "side"), [(0, 0, 1), (2, 1, 1), (3, 1, -1)])
def test_sawteeth_are_those_of_the_page(row, period, side):
    found = rcwa_more.sawtooth_row(rcwa_more.SAWTEETH[period], side)
    np.testing.assert_allclose(found, numbers_of("sawtooth", row)[:4], atol=2e-3)


def test_the_preset_blazed_grating_passes_1_and_capped_does_not():
    """Published for the issue: 0.836 (TE) and 0.865 (TM) rigorous, 1.025 with R = 1."""
    te, tm, plain, capped = rcwa_more.sawtooth_row(2.5e-6, 1)
    assert (te, tm) == (pytest.approx(0.836, abs=0.01), pytest.approx(0.865, abs=0.01))
    assert plain == pytest.approx(1.025, abs=1e-3)
    flat = np.mean(fresnel(ALUMINIUM, np.arcsin(0.11)))
    assert capped * flat == pytest.approx(0.5 * (te + tm), rel=0.02)


@pytest.mark.parametrize("angle", rcwa_more.FILM_ANGLES)
def test_a_film_that_follows_the_relief_is_within_5_percent(angle):
    stated = numbers_of("films", rcwa_more.FILM_ANGLES.index(angle))
    for thickness, on_page in zip(rcwa_more.FILMS_NM, stated, strict=False):
        coated, bare = rcwa_more.film_errors(thickness, angle)
        assert bare < 0.05 and coated < 0.05
        assert 100 * coated == pytest.approx(on_page, abs=0.02)


@pytest.mark.parametrize("angle", rcwa_more.DISC_ANGLES)
def test_a_disc_under_its_plastic_is_within_5_percent(angle):
    under, imitated = rcwa_more.disc_errors(angle)
    assert under < 0.05 < imitated
    assert [100 * under, 100 * imitated] == pytest.approx(
        numbers_of("disc", rcwa_more.DISC_ANGLES.index(angle)), abs=0.1
    )
