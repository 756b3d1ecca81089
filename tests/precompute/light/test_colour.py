# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour integrals, matrices and the gamut step."""

from __future__ import annotations

import numpy as np
import pytest

from precompute.errors import ParameterError
from precompute.light import colour as c
from precompute.light.illuminant import ILLUMINANTS

#: Chromaticities of the illuminants, CIE 15:2018 (tables T.3 and T.8.1), to the digits printed there.
CHROMATICITY = {
    "A": (0.44758, 0.40745),
    "D50": (0.34567, 0.35851),
    "D65": (0.31272, 0.32903),
    "E": (1 / 3, 1 / 3),
    "FL11": (0.3805, 0.3769),
}


@pytest.mark.parametrize("name", ILLUMINANTS)
def test_white_has_the_published_chromaticity(name):
    xyz = c.white_xyz(name)
    assert xyz[1] == pytest.approx(1.0, abs=1e-14)
    # The published values integrate 360-830 nm; 380-780 nm changes the fourth digit.
    assert np.allclose(xyz[:2] / xyz.sum(), CHROMATICITY[name], atol=4e-4)


def test_flat_spectrum_has_unit_luminance_at_every_step():
    for step in (5e-9, 4e-9, 2.5e-9, 2e-9, 1e-9, 0.5e-9):
        lam, weights = c.spectral_weights(step_m=step)
        assert lam[0] == 380e-9
        assert lam[-1] == pytest.approx(780e-9, abs=1e-18)
        assert np.diff(lam).max() == pytest.approx(step, rel=1e-9)
        assert weights[:, 1].sum() == pytest.approx(1.0, abs=1e-14)


def test_weights_integrate_a_line_by_the_trapezoid_rule():
    """Ends count half: under illuminant E, the mean of ybar-weighted wavelength is the photopic centroid, 560 nm."""
    lam, weights = c.spectral_weights(illuminant="E")
    assert weights[:, 1] @ lam == pytest.approx(560e-9, abs=1e-9)
    coarse, w5 = c.spectral_weights(np.arange(380, 781, 5) * 1e-9, "E")
    assert w5[:, 1] @ coarse == pytest.approx(weights[:, 1] @ lam, rel=1e-4)


@pytest.mark.parametrize("space", c.SPACES)
@pytest.mark.parametrize("illuminant", ILLUMINANTS)
def test_white_of_the_illuminant_is_white_of_the_space(space, illuminant):
    matrix = c.xyz_to_rgb_matrix(space, illuminant)
    assert np.allclose(matrix @ c.white_xyz(illuminant), 1.0, atol=1e-12)
    row = c.luminance_row(space, illuminant)
    assert row.sum() == pytest.approx(1.0, abs=1e-12)
    xyz = np.random.default_rng(3).random((5, 3))
    assert np.allclose(c.xyz_to_rgb(xyz, space, illuminant) @ row, xyz[:, 1])


def test_rec709_agrees_with_the_srgb_standard():
    """IEC 61966-2-1 prints this matrix; the illuminant's white differs from the standard's in the fourth digit."""
    printed = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    assert np.allclose(c.xyz_to_rgb_matrix(), printed, atol=3e-3)


def test_gamut_step_keeps_luminance_and_hue():
    row = c.luminance_row()
    rng = np.random.default_rng(4)
    rgb = rng.normal(0.4, 0.6, (500, 3))
    rgb = rgb[rgb @ row > 0]
    moved = c.into_gamut(rgb, row)
    assert moved.min() >= 0
    assert np.allclose(moved @ row, rgb @ row)
    inside = rgb.min(axis=1) >= 0
    assert inside.any()
    assert (~inside).any()
    assert np.array_equal(moved[inside], rgb[inside])
    grey = (rgb @ row)[:, None]
    # Same line through grey: the cross product of the two differences vanishes, and the direction is kept.
    assert np.allclose(np.cross(rgb - grey, moved - grey), 0, atol=1e-12)
    assert (np.einsum("ij,ij->i", rgb - grey, moved - grey) >= 0).all()
    assert np.allclose(moved[~inside].min(axis=1), 0, atol=1e-12)


@pytest.mark.parametrize("space", c.SPACES)
def test_gamut_step_on_spectral_colours(space):
    """Orders of a grating are nearly spectral: luminance and dominant wavelength stay, the sign of none flips.

    The dominant wavelength is colour-science's, found on the spectral locus of the xy diagram.
    """
    import colour

    lam, weights = c.spectral_weights()
    white = c.white_xyz()
    matrix, row = c.xyz_to_rgb_matrix(space), c.luminance_row(space)
    for centre in (450, 475, 500, 520, 550, 580, 610, 640):
        xyz = np.exp(-0.5 * ((lam * 1e9 - centre) / 8) ** 2) @ weights
        rgb = matrix @ xyz
        moved = c.into_gamut(rgb, row)
        assert moved.min() >= 0
        back = np.linalg.solve(matrix, moved)
        assert back[1] == pytest.approx(xyz[1], rel=1e-12)
        found = [colour.dominant_wavelength(each[:2] / each.sum(), white[:2] / white.sum())[0] for each in (xyz, back)]
        assert found[0] == pytest.approx(centre, abs=4)
        assert found[1] == pytest.approx(found[0], abs=0.5)


def test_gamut_step_without_luminance_is_black():
    row = c.luminance_row()
    assert np.array_equal(c.into_gamut([[-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]], row), np.zeros((2, 3)))


@pytest.mark.parametrize("call", [lambda: c.spectral_weights(illuminant="D66"), lambda: c.spectral_weights(step_m=0.0),
                                  lambda: c.spectral_weights(np.array([300e-9, 400e-9])),
                                  lambda: c.xyz_to_rgb_matrix("sRGB")])  # fmt: skip
def test_bad_input_is_refused(call):
    with pytest.raises(ParameterError):
        call()
