# SPDX-License-Identifier: GPL-3.0-or-later
"""Lattice vectors from the spectrum: exact for gratings, right for disordered structures, none where there is none."""

import numpy as np
import pytest

from precompute.presets import make_preset
from precompute.readers import read_scan
from precompute.scan.heightfield import HeightField
from precompute.scan.lattice import find_lattice, power_spectrum

SHAPE, DX, DY = (240, 300), 80e-9, 100e-9


def waves(*vectors, noise=0.0):
    """A sum of waves with the given frequencies in 1/um, on a tilted plane."""
    x, y = (np.arange(SHAPE[1]) + 0.5) * DX * 1e6, (np.arange(SHAPE[0]) + 0.5) * DY * 1e6
    heights = sum(np.cos(2 * np.pi * (fx * x[None, :] + fy * y[:, None]) + 1.0) for fx, fy in vectors)
    heights = heights + 0.7 * x[None, :] - 0.2 * y[:, None]
    heights += noise * np.random.default_rng(8).standard_normal(SHAPE)
    return HeightField(1e-8 * heights, DX, DY)


@pytest.mark.parametrize("vector", [(1.0, 0.0), (0.0, 0.8137), (0.613, 0.707), (-0.9, 0.41)])
@pytest.mark.parametrize("noise", [0.0, 0.5])
def test_a_wave_is_found_to_a_hundredth_of_a_bin(vector, noise):
    lattice = find_lattice(waves(vector, noise=noise))
    assert len(lattice.frequencies) == 1
    bins = np.array([DX * SHAPE[1], DY * SHAPE[0]]) * 1e6
    np.testing.assert_allclose(lattice.frequencies[0] * 1e-6 * bins, np.array(vector) * bins, atol=0.01 + 0.05 * noise)
    assert lattice.spacings_m[0] == pytest.approx(1e-6 / np.hypot(*vector), rel=2e-3)


def test_two_crossed_waves_span_a_lattice():
    lattice = find_lattice(waves((1.02, 0.0), (0.51, 0.883)))
    assert len(lattice.frequencies) == 2
    np.testing.assert_allclose(lattice.vectors_m @ lattice.frequencies.T, np.eye(2), atol=1e-9)
    # A hexagonal lattice: two equally long vectors.
    assert np.hypot(*lattice.vectors_m[0]) == pytest.approx(np.hypot(*lattice.vectors_m[1]), rel=5e-3)


def test_a_grating_has_one_period_and_its_harmonics_are_not_another():
    lattice = find_lattice(make_preset("blazed", period_um=2.3, size_m=40e-6))
    assert len(lattice.frequencies) == 1
    assert lattice.spacings_m[0] == pytest.approx(2.3e-6, rel=2e-3)


def test_the_snake_has_rows_and_fingers():
    spacings = np.sort(find_lattice(make_preset("snake")).spacings_m)
    assert spacings[1] == pytest.approx(1.5e-6, rel=0.04)
    assert 0.50e-6 < spacings[0] < 0.59e-6


def test_the_scanned_skin_has_rows_and_fingers(scan_dir):
    field = read_scan(scan_dir / "xenopeltis_65um_818.69nm.png", (65e-6, 65e-6), 818.69e-9)
    spacings = np.sort(find_lattice(field).spacings_m)
    assert spacings[1] == pytest.approx(1.5e-6, rel=0.04)
    assert 0.50e-6 < spacings[0] < 0.59e-6


def test_the_bump_array_is_hexagonal(scan_dir):
    lattice = find_lattice(read_scan(scan_dir / "hexagonal_bumps_15um.002"))
    assert len(lattice.frequencies) == 2
    assert np.all((lattice.spacings_m > 0.518e-6) & (lattice.spacings_m < 0.532e-6))
    first, second = lattice.frequencies
    cosine = abs(first @ second) / np.hypot(*first) / np.hypot(*second)
    assert np.degrees(np.arccos(cosine)) == pytest.approx(60, abs=2)


@pytest.mark.parametrize("name", ["flat", "stam_bumps"])
def test_no_period_where_there_is_none(name):
    lattice = find_lattice(make_preset(name))
    assert lattice.frequencies.shape == (0, 2)
    assert lattice.vectors_m.shape == (0, 2)


def test_the_power_spectrum_sums_to_the_variance():
    field = waves((1.0, 0.3), noise=0.4)
    power, fx, fy = power_spectrum(field)
    x, y = np.meshgrid(np.arange(SHAPE[1]), np.arange(SHAPE[0]))
    design = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1).reshape(-1, 6) / 300.0
    rest = field.heights.ravel() - design @ np.linalg.lstsq(design, field.heights.ravel(), rcond=None)[0]
    assert power.sum() == pytest.approx(rest.var(), rel=1e-6)
    assert power.shape == (fy.size, fx.size)
