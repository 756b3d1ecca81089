# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflectance: estimated periods against direct summation, and against the periods of real scans."""

from __future__ import annotations

import json

import numpy as np
import pytest

from precompute.cli import main
from precompute.errors import ParameterError
from precompute.evaluate.reflectance import Plane, estimated_periods, grating_curve, response, steps
from precompute.presets import make_preset

WAVELENGTHS = np.arange(380, 781, 5) * 1e-9
VIEWS = np.radians(-55 + 0.01 * np.arange(1501))


def plane(**changes):
    return Plane(**{"theta_i": np.radians(75), "theta_r": VIEWS, "wavelengths_m": WAVELENGTHS, **changes})


def summed(line, dx, window, copies=1):
    """(mean, variance) of the period by direct summation along x of a surface that is uniform along y."""
    x = (np.arange(line.size) - (line.size - 1) / 2) * dx
    sin_i, cos_i = np.sin(np.radians(75)), np.cos(np.radians(75))
    sin_r, cos_r = np.sin(VIEWS), np.cos(VIEWS)
    u, w = -(sin_i + sin_r), -(cos_i + cos_r)
    factor = (1 + sin_i * sin_r + cos_i * cos_r) ** 2 / (w**2 * cos_r)

    def power(views, k):
        P = (window * np.exp(1j * k * (u[views, None] * x + w[views, None] * line))).sum(axis=1)
        P = P * np.exp(1j * k * np.outer(u[views], np.arange(copies)) * line.size * dx).sum(axis=1)
        return factor[views] * np.abs(P) ** 2

    periods = []
    for wavelength in WAVELENGTHS:
        k = 2 * np.pi / wavelength
        # Every fifth view first; lobes are wider than that.
        coarse = 5 * power(np.arange(0, VIEWS.size, 5), k).argmax()
        near = np.arange(max(coarse - 8, 0), min(coarse + 9, VIEWS.size))
        best = near[power(near, k).argmax()]
        periods.append(1e9 * wavelength / (sin_i + sin_r[best]))
    return np.mean(periods), np.var(periods)


#: mean in nm and variance in nm^2 that direct summation gives for the blazed grating of the thesis.
KNOWN = {
    (False, "windowed"): (2499.58, 0.416),
    (True, "windowed"): (2500.24, 0.184),
    (False, 26): (2499.57, 0.92),
    (True, 26): (2502.36, 0.51),
    (False, 100): (2499.96, 0.150),
    (True, 100): (2500.16, 0.152),
}


@pytest.mark.parametrize("mirror", [False, True])
def test_blazed_grating_by_the_windowed_method(mirror):
    sigma = 16.25e-6
    # A strip is enough: the grating is uniform along y, and the window separates.
    field = make_preset("blazed", (65e-6, 2e-6), 1300, period_um=2.5, depth_nm=250, mirror=mirror)
    values, _ = response(field, plane(), "windowed", sigma_s_m=sigma)
    nm = estimated_periods(plane(), values)[1] * 1e9
    x = (np.arange(1300) - 649.5) * field.dx
    expected = summed(field.heights[0], field.dx, np.exp(-(x**2) / (2 * sigma**2)))
    assert (nm.mean(), nm.var()) == pytest.approx(expected, abs=1e-3)
    assert (nm.mean(), nm.var()) == pytest.approx(KNOWN[mirror, "windowed"], abs=0.05)


@pytest.mark.parametrize("mirror", [False, True])
@pytest.mark.parametrize("copies", [26, 100])
def test_blazed_grating_by_the_periodic_method(mirror, copies):
    tile = make_preset("blazed", 2.5e-6, 50, period_um=2.5, depth_nm=250, mirror=mirror)
    values, _ = response(tile, plane(), "pq", replicas=(copies, copies))
    nm = estimated_periods(plane(), values)[1] * 1e9
    assert (nm.mean(), nm.var()) == pytest.approx(summed(tile.heights[0], tile.dx, 1.0, copies), abs=1e-3)
    assert nm.mean() == pytest.approx(KNOWN[mirror, copies][0], abs=0.05)
    assert nm.var() == pytest.approx(KNOWN[mirror, copies][1], abs=0.1 if copies == 26 else 0.05)


def test_grating_curve_solves_the_grating_equation():
    here = plane(order=2)
    views = grating_curve(here, 2500e-9)
    assert np.allclose(2500e-9 * (np.sin(here.theta_i) + np.sin(views)), 2 * WAVELENGTHS)
    assert np.isnan(grating_curve(here, 700e-9)[-1])


def test_azimuth_turns_the_plane_with_the_grating():
    """A grating turned by 90 degrees seen in the plane at 90 degrees is the first grating."""
    from precompute.scan.heightfield import HeightField

    field = make_preset("blazed", 10e-6, 100, period_um=2.5, depth_nm=250)
    turned = HeightField(field.heights.T, field.dy, field.dx)
    few = {"theta_r": np.radians(np.arange(-55, -40, 0.5)), "wavelengths_m": np.array([450e-9, 600e-9])}
    a, _ = response(field, plane(**few), sigma_s_m=2e-6)
    b, _ = response(turned, plane(**few, phi=np.pi / 2), sigma_s_m=2e-6)
    assert np.allclose(a, b, rtol=1e-6, atol=1e-9 * a.max())


def test_normalisations_differ_by_the_known_factor():
    """rho / f = cos_i lambda^2 / area for every method."""
    field = make_preset("blazed", 10e-6, 100, period_um=2.5, depth_nm=250)
    few = plane(theta_r=np.radians(np.arange(-55.0, -40, 1)), wavelengths_m=np.array([450e-9, 600e-9]))
    area = 100 * 100 * field.dx * field.dy * 4
    relative, _ = response(field, few, "pq", "relative", replicas=(2, 2))
    absolute, _ = response(field, few, "pq", "absolute", replicas=(2, 2))
    factor = np.cos(few.theta_i) * few.wavelengths_m[:, None] ** 2 / area
    assert np.allclose(relative, absolute * factor)


def test_command_line_writes_numbers_and_plot(tmp_path, capsys):
    tile = tmp_path / "tile.gsf"
    shape = ("--size-um", "2.5", "--pixels", "50", "--period-um", "2.5", "--depth-nm", "250")
    assert main(["preset", "blazed", "--out", str(tile), *shape]) == 0
    capsys.readouterr()
    views = ("--theta-i", "75", "--from", "-55", "--to", "-40")
    options = ("--method", "pq", "--replicas", "26", "--out", str(tmp_path / "plot.png"), "--json")
    assert main(["reflectance", str(tile), *views, *options]) == 0
    data = json.loads(capsys.readouterr().out)
    assert data["mean_nm"] == pytest.approx(2499.57, abs=0.05)
    assert data["variance_nm2"] == pytest.approx(0.92, abs=0.1)
    assert [point["wavelength_nm"] for point in data["curve"]] == pytest.approx(list(range(380, 781, 5)))
    assert data["mean_nm"] == pytest.approx(np.mean([point["period_nm"] for point in data["curve"]]))
    assert (tmp_path / "plot.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    "options",
    [
        ("--from", "-40", "--to", "-55"),
        ("--from", "-80", "--to", "-60"),
        ("--from", "10", "--to", "95"),
        ("--from", "-55", "--to", "-40", "--step", "0"),
        ("--from", "-55", "--to", "-40", "--order", "0"),
        ("--from", "-55", "--to", "-40", "--method", "pq", "--replicas", "0"),
        ("--from", "-55", "--to", "-40", "--replicas", "3"),
        ("--from", "-55", "--to", "-40", "--lattice", "3"),
        ("--from", "-55", "--to", "-40", "--out", "plot.jpg"),
        ("--from", "-55", "--to", "-40", "--ensemble", "average"),
    ],
)
def test_bad_options_end_with_one_sentence(tmp_path, capsys, options):
    path = tmp_path / "grating.gsf"
    main(["preset", "blazed", "--out", str(path), "--size-um", "5", "--pixels", "50", "--depth-nm", "250"])
    capsys.readouterr()
    assert main(["reflectance", str(path), "--theta-i", "75", *options]) == 2
    error = capsys.readouterr().err.strip()
    assert error.endswith(".")
    assert len(error.splitlines()) == 1


def test_plane_refuses_the_mirror():
    with pytest.raises(ParameterError, match="mirror"):
        plane(theta_r=np.radians(np.arange(-80.0, -60.0)))


@pytest.mark.parametrize(
    ("name", "reading", "theta_i", "views"),
    [
        ("hexagonal_bumps_15um.002", {}, 75, (-20, 35, 0.1)),
        ("xenopeltis_65um_818.69nm.png", {"size_m": (65e-6, 65e-6), "height_m": 818.69e-9}, 60, (-46, -10, 0.1)),
    ],
)
def test_period_of_a_real_scan_agrees_with_its_spectrum(scan_dir, name, reading, theta_i, views):
    from precompute.parameters import BakeParameters
    from precompute.readers import read_scan
    from precompute.scan.lattice import find_lattice
    from precompute.scan.preparation import prepare

    patch = prepare(read_scan(scan_dir / name, **reading), BakeParameters(level="poly2", clip_percent=99.9))
    lattice = find_lattice(patch)
    fx, fy = lattice.frequencies[0]
    here = Plane(np.radians(theta_i), np.radians(steps(*views)), steps(400, 760, 20) * 1e-9, float(np.arctan2(fy, fx)))
    values, _ = response(patch, here, tolerance=1e-4)
    periods = estimated_periods(here, values)[1]
    assert periods.mean() == pytest.approx(lattice.spacings_m[0], rel=0.01)
    assert periods.std() < 0.01 * periods.mean()
