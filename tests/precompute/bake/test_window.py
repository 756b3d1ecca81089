# SPDX-License-Identifier: GPL-3.0-or-later
"""Which limit a coherence window has, what a patch cuts off of it, and what sunlight's makes of a disc's colours."""

import json

import numpy as np
import pytest

from precompute.bake import bake
from precompute.bake.window import coherence, side_lobes, sunlight_sigma_s
from precompute.cli import main
from precompute.evaluate import delta_e_2000
from precompute.light.colour import spectral_weights
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan import HeightField, write_gsf


def flat(side_um):
    return HeightField(np.zeros((64, 64)), side_um * 1e-6 / 64, side_um * 1e-6 / 64)


def test_side_lobes_of_a_window_that_the_patch_cuts_off():
    """Of the issue: 16.25 um on 40 and on 65 um."""
    assert side_lobes(40e-6, 16.25e-6) == pytest.approx(1.4e-2, rel=0.05)
    assert side_lobes(65e-6, 16.25e-6) == pytest.approx(6e-4, rel=0.1)
    assert side_lobes(1e-6, 1.0) == pytest.approx(0.0472, rel=0.01)  # of a rectangle, sinc^2


@pytest.mark.parametrize(
    ("side_um", "ensemble", "typed", "sigma_um", "limit", "warns"),
    [
        (40.0, "single", None, 10.0, "quarter of the side", False),
        (80.0, "single", None, 16.25, "sunlight", False),
        (40.0, "single", 16.25, 16.25, "typed", True),
        (40.0, "single", 10.0, 10.0, "typed", False),
        (40.0, "average", None, 4.0, "tenth of the side", False),
        (40.0, "average", 16.25, 16.25, "typed", False),
        (40.0, "periodic", 3.0, 12.0, "copies", False),
    ],
)
def test_what_limits_a_window(side_um, ensemble, typed, sigma_um, limit, warns):
    found = coherence(flat(side_um), ensemble, None if typed is None else typed * 1e-6)
    assert found.sigma_s_m == pytest.approx(sigma_um * 1e-6)
    assert (found.limit, bool(found.warning)) == (limit, warns)
    if warns:
        assert "1.4e-02" in found.warning
    assert sunlight_sigma_s(flat(side_um)) == pytest.approx(min(side_um / 4, 16.25) * 1e-6)


def test_commands_and_sidecar_say_it(tmp_path, capsys):
    path = tmp_path / "flat.gsf"
    write_gsf(flat(6.0), path)
    assert main(["info", str(path), "--json"]) == 0
    windows = json.loads(capsys.readouterr().out)["coherence"]
    assert windows["single"]["limit"] == "quarter of the side"
    assert main(["info", str(path)]) == 0
    assert "coherence single 1.5 um (quarter of the side)" in capsys.readouterr().out
    given = ["bake", str(path), "--out", str(tmp_path), "--ensemble", "single", "--detail", "0.2"]
    assert main([*given, "--sigma-s-um", "3", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["coherence"]["limit"] == "typed" and any("side lobes" in note for note in said["notes"])
    assert json.loads((tmp_path / "flat.json").read_text())["coherence"] == said["coherence"]


def groove(side_um):
    """The track of a CD without data: what its pits scatter beside the orders is no matter of the window."""
    field = make_preset("cd", size_m=side_um * 1e-6)
    line = field.heights.max(axis=0)
    return HeightField(np.tile(line, (len(line), 1)), field.dx, field.dy)


def order_under_the_sun(field, period, u, w):
    """XYZ of a grating's first order over sines ``u`` in its plane, under the sun's disc.

    Integrated across the plane, where the disc's chord is what is left of it.
    """
    wavelengths, weights = spectral_weights()
    x = (np.arange(field.shape[1]) + 0.5) * field.dx
    k = 2.0 * np.pi / wavelengths
    p = np.exp(-1j * k[:, None, None] * w * field.heights).mean(axis=1)
    efficiency = np.abs((p * np.exp(2j * np.pi * x / period)).mean(axis=1)) ** 2
    radius = np.radians(0.533 / 2)
    chord = np.sqrt(np.maximum(radius**2 - (u[:, None] - wavelengths / period) ** 2, 0.0))
    return (chord * efficiency) @ weights


@pytest.mark.slow
def test_a_disc_in_sunlight_has_the_colours_of_the_suns_own_width():
    """First order of a CD: the window of sunlight, cut by the patch, is off by 2; a tenth of 40 um by 14."""
    u = np.linspace(0.26, 0.43, 80)
    differences = {}
    for name, field, sigma in (
        ("look", groove(65.6), 16.25e-6),
        ("tenth", groove(40.0), None),
    ):
        table = bake(field, BakeParameters(sigma_s_m=sigma, error=0.1))
        assert table.info["coherence"]["limit"] == ("typed" if sigma else "tenth of the side")
        v = np.linspace(-0.1, 0.1, 201)[:, None]
        seen = table.transform(-u, v, -1.9).sum(axis=0)
        truth = order_under_the_sun(field, 1.6e-6, u, 1.9)
        # Both as bright: what counts is the colour.
        seen, truth = (each / each[:, 1].max() for each in (seen, truth))
        differences[name] = delta_e_2000(seen, truth, 0.6)
    assert np.median(differences["look"]) < 2.5 and differences["look"].max() < 6.0
    assert np.median(differences["tenth"]) > 8.0
