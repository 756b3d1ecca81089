# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets are looks: the table is whole, and what it says can be baked."""

import numpy as np
import pytest

from precompute.bake import bake
from precompute.bake.cost import bake_cost
from precompute.evaluate.surface import brdf
from precompute.light.colour import xyz_to_rgb
from precompute.parameters import ENSEMBLES, LEVELS, BakeParameters
from precompute.presets import LOOKS, PRESETS, look_of, make_preset
from precompute.scan.preparation import prepare
from precompute.stack import parse_stack, split_films


def test_every_preset_has_a_look_and_no_other():
    assert set(LOOKS) == set(PRESETS)
    assert look_of("cd").orientation == look_of("dvd").orientation == look_of("bluray").orientation == "RADIAL"
    assert all(look.level == "none" for look in LOOKS.values())  # computed heights lie level
    assert look_of("no such preset") == look_of("snake")


def parameters_of(look, **more):
    more.setdefault("error", 0.01 * look.error_percent)
    return BakeParameters(
        sigma_s_m=look.sigma_s_um * 1e-6 or None, ensemble=look.ensemble, level=look.level,
        stack=parse_stack(look.substrate, split_films(look.films)), lacquer=look.lacquer or None, **more,
    )  # fmt: skip


@pytest.mark.parametrize("name", PRESETS)
def test_a_look_fits_its_patch(name):
    """The window is at most a quarter of the patch, else the patch cuts it off; the table stays moderate."""
    look = LOOKS[name]
    assert look.ensemble in ENSEMBLES and look.level in LEVELS
    size_um = look.patch_um or PRESETS[name].size_um
    assert look.sigma_s_um <= size_um / 4.0
    parameters = parameters_of(look)
    field = prepare(make_preset(name, size_um * 1e-6, look.patch_pixels or None), parameters)
    cost = bake_cost(field, parameters)
    assert cost.texel_bytes < 60e6 < cost.refined_bytes


def test_a_look_says_what_it_is():
    assert look_of("blazed").summary() == (
        "conductor, along the UV map, levelling none, average, coherence 16.25 um on 65 um, error 10 %"
    )
    assert look_of("cd").summary() == (
        "Al under polycarbonate, radial, levelling none, average, coherence 16.25 um on 65.6 um, error 10 %"
    )
    assert look_of("titanium_ripple").summary().startswith("TiO2:50 on Ti, along")
    assert "dielectric of index 1.55" in look_of("snake").summary()


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [("morpho", 460, 480), ("jewel_beetle", 520, 540)],  # Kinoshita et al. 2002; Stavenga et al. 2011
)
def test_a_stack_peaks_where_the_animal_does(name, low, high):
    """Reflectance at normal incidence, whose peak then moves to shorter waves (Bragg's law)."""
    lam, stack = np.arange(380, 781, 1.0), parameters_of(LOOKS[name]).stack
    r = stack.reflectance(lam * 1e-9, np.cos(np.radians([0.0, 40.0])))
    peak, oblique = lam[r.argmax(axis=0)]
    assert low <= peak <= high
    assert oblique < peak - 20
    assert r[:, 0].max() > 3 * np.median(r[:, 0])


@pytest.mark.parametrize(
    ("name", "order"),
    [
        ("morpho", "bgr"),
        ("gold_foil", "rgb"),
        ("copper_plate", "rgb"),
        ("titanium_ripple", "bgr"),
        ("jewel_beetle", "gbr"),
    ],
)
def test_a_look_has_its_hue_in_all_directions_together(name, order):
    """Light from above, f cos over all views: the colour that a white room shows, strongest channel first."""
    field = make_preset(name, size_m=min(PRESETS[name].size_um, 34.0) * 1e-6)
    table = bake(field, parameters_of(LOOKS[name], detail=0.4))
    rng = np.random.default_rng(3)
    radius, turn = np.sqrt(rng.uniform(0, 0.96, 40000)), rng.uniform(0, 2 * np.pi, 40000)
    views = np.stack([radius * np.cos(turn), radius * np.sin(turn), np.sqrt(1 - radius**2)], -1)
    rgb = xyz_to_rgb(brdf(table, np.array([0.0, 0.0, 1.0]), views).mean(0))
    assert "".join(sorted("rgb", key=lambda c: -rgb["rgb".index(c)])) == order
    assert max(rgb) > 1.25 * min(rgb)


def test_the_page_shows_the_table(root_dir):
    page = (root_dir / "docs" / "presets.md").read_text(encoding="utf-8")
    for name, preset in PRESETS.items():
        assert f"| `{name}` | {preset.label} | {LOOKS[name].summary()} |" in page
