# SPDX-License-Identifier: GPL-3.0-or-later
"""The integral over wavelength against plain sums, and where every second frequency is enough for it."""

import numpy as np
import pytest

from precompute.bake.baking import ANGLES_A_BLOCK, blocks_of_angles
from precompute.bake.energy import sector_shares
from precompute.bake.series import chebyshev_nodes
from precompute.bake.spectral_sum import RADIAL_STEP, SpectralSum, coarse_from
from precompute.bake.transforms import lobe_width
from precompute.constants import KAPPA_MAX
from precompute.light import spectral_weights
from precompute.light.illuminant import Spectrum
from precompute.table.albedo import sector_means
from precompute.table.layout import TableLayout

SIGMA = 6.5e-6
STEP = RADIAL_STEP * lobe_width(SIGMA)
FREQUENCIES = STEP * np.arange(int(2 / 380e-9 / STEP) + 6)
NODES = chebyshev_nodes(KAPPA_MAX, 5)
RADII = 0.02 * np.sinh(np.linspace(0.0, np.arcsinh(100.0), 40))
SLICES = np.array([0.3, 1.1, 2.0])


def intensity(f, kappa, angle):
    """Speckle of lags up to 4 sigma_s, the larger ones as dim as a bake's, times a quadratic in kappa."""
    random = np.random.default_rng(3)
    lags, phases = random.uniform(0.0, 4.0, (8, 1)), random.uniform(0.0, 6.0, (8, 1))
    waves = np.cos(2.0 * np.pi * SIGMA * lags * f.ravel() + phases + angle) * np.exp(-0.25 * lags**2)
    return (2.0 + waves.mean(0)).reshape(f.shape) * (1.0 + (kappa / KAPPA_MAX) ** 2)


def laser():
    nm = np.arange(380.0, 780.5, 0.5)
    return Spectrum(tuple(nm * 1e-9), tuple(np.exp(-0.5 * ((nm - 532.0) / 1.0) ** 2)))


@pytest.mark.parametrize("illuminant", ["D65", "FL11", laser()], ids=str)
@pytest.mark.parametrize("with_reflectance", [False, True])
def test_equals_the_plain_sum_over_wavelengths(illuminant, with_reflectance):
    wavelengths, weights = spectral_weights(illuminant=illuminant)
    gain = 1.0 - 0.3 * SLICES[:, None] * np.linspace(0.0, 0.5, len(wavelengths))

    def seen(r, slices):
        """Fringes of a film, as wide as those of 1 um."""
        return 0.5 + 0.4 * np.cos(2.0 * np.pi * 2e-6 / wavelengths + r + slices[:, None])

    reflectance = seen if with_reflectance else None
    total = SpectralSum(FREQUENCIES, NODES, KAPPA_MAX, RADII, SLICES, wavelengths, weights, None, reflectance, gain)
    angles = np.array([0.0, 1.0, 2.5])
    given = [
        np.stack([[intensity(np.array(f), NODES, a) for f in grid] for a in angles]).astype(np.float32)
        for grid in total.grids
    ]
    found = total.apply(given)
    for index, r in enumerate(RADII):
        for k, w in enumerate(SLICES):
            factor = weights / wavelengths[:, None] ** 2 * gain[k, :, None]
            if reflectance is not None:
                factor = factor * seen(r, SLICES)[k][:, None]
            for m, angle in enumerate(angles):
                expected = intensity(r / wavelengths, 2.0 * np.pi * w / wavelengths, angle) @ factor
                assert found[index, k, :, m] == pytest.approx(expected, rel=6e-4, abs=6e-4 * expected.max())


def test_coarse_and_fine_grids_give_the_same():
    """Within a quarter of what half floats round."""
    wavelengths, weights = spectral_weights()
    sums = [
        SpectralSum(FREQUENCIES, NODES, KAPPA_MAX, RADII, SLICES, wavelengths, weights, coarse=coarse)
        for coarse in (None, len(RADII))
    ]
    assert [len(each.grids) for each in sums] == [2, 1]
    assert len(sums[0].grids[0]) < 0.3 * len(FREQUENCIES)
    coarse, fine = (
        each.apply([np.array([[intensity(np.array(f), NODES, 0.4) for f in g]], np.float32) for g in each.grids])
        for each in sums
    )
    assert np.abs(coarse / fine - 1.0).max() < 2.0**-13


def test_the_light_says_where_every_second_frequency_will_do():
    def first_radius(illuminant, sigma_s=SIGMA):
        wavelengths, weights = spectral_weights(illuminant=illuminant)
        step = RADIAL_STEP * lobe_width(sigma_s)
        index = coarse_from(step, RADII, SLICES, wavelengths, weights)
        return RADII[index] if index < len(RADII) else np.inf

    day = first_radius("D65")
    assert 0.2 < day < 0.6
    # Twice as narrow a window, twice as wide a lobe: twice as far out.
    assert first_radius("D65", SIGMA / 2) == pytest.approx(2.0 * day, rel=0.5)
    assert first_radius("FL11") > 3.0 * day
    assert first_radius(laser()) == np.inf


def test_blocks_of_angles_are_even_and_whole():
    """Of half a circle."""
    for count in (128, 144, 432, 500, 1600, 6496):
        blocks = blocks_of_angles(count)
        assert [block.start for block in blocks] == [0, *(block.stop for block in blocks[:-1])]
        assert blocks[-1].stop == count
        sizes = [block.stop - block.start for block in blocks]
        assert max(sizes) <= ANGLES_A_BLOCK
        if count > 300:
            assert len(blocks) % 6 in (0, 5)  # 2 or 6 threads wait for less than a block at the end


@pytest.mark.parametrize("n_phi", [288, 256, 992])
def test_sectors_share_the_rows_of_angles(n_phi):
    """Means over sectors, also where their edges fall within rows: rows repeated 144 times are divided evenly."""
    layout = TableLayout(n_r=3, n_phi=n_phi, n_w=3, r0=0.1, w0=0.4, w_min=0.1)
    values = np.random.default_rng(4).random((3, 3, 3, n_phi)).astype(np.float32)
    expected = np.repeat(values, 144, axis=-1).reshape(3, 3, 3, 144, n_phi).mean(-1)
    assert sector_means(values, 144) == pytest.approx(expected, rel=1e-5)
    total = np.zeros((144, 9))
    for block in blocks_of_angles(n_phi):
        low, share = sector_shares(layout, block.start, block.stop)
        total[low : low + len(share)] += share @ values[..., block].reshape(-1, block.stop - block.start)[:9].T
    assert total == pytest.approx(expected.reshape(-1, 144)[:9].T, rel=1e-5)
