# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets are looks: the table is whole, and what it says can be baked."""

import pytest

from precompute.bake.cost import bake_cost
from precompute.parameters import ENSEMBLES, LEVELS, BakeParameters
from precompute.presets import LOOKS, PRESETS, look_of, make_preset
from precompute.scan.preparation import prepare


def test_every_preset_has_a_look_and_no_other():
    assert set(LOOKS) == set(PRESETS)
    assert look_of("cd").orientation == look_of("dvd").orientation == look_of("bluray").orientation == "RADIAL"
    assert all(look.level == "none" for look in LOOKS.values())  # computed heights lie level
    assert look_of("no such preset") == look_of("snake")


@pytest.mark.parametrize("name", PRESETS)
def test_a_look_fits_its_patch(name):
    """The window is at most a quarter of the patch, else the patch cuts it off; the table stays moderate."""
    look = LOOKS[name]
    assert look.ensemble in ENSEMBLES and look.level in LEVELS
    assert look.sigma_s_um <= PRESETS[name].size_um / 4.0
    parameters = BakeParameters(sigma_s_m=look.sigma_s_um * 1e-6 or None, ensemble=look.ensemble, level=look.level)
    field = prepare(make_preset(name), parameters)
    assert bake_cost(field, parameters).texel_bytes < 60e6


def test_a_look_says_what_it_is():
    assert look_of("cd").summary() == "conductor, radial, levelling none, average, coherence 8 um"
    assert "dielectric of index 1.55" in look_of("snake").summary()


def test_the_page_shows_the_table(root_dir):
    page = (root_dir / "docs" / "presets.md").read_text(encoding="utf-8")
    for name, preset in PRESETS.items():
        assert f"| `{name}` | {preset.label} | {LOOKS[name].summary()} |" in page
