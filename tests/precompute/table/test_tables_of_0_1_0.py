# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that 0.1.0 saved read as they did, bit for bit, and its bakes come out as they did, to rounding."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from precompute.bake import bake, balance
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.table import SpectralTable
from tests.support import v0_1_0

SCRIPT = v0_1_0.script()


def test_a_table_reads_as_it_did():
    """Each texel, and T and the albedo between the texels."""
    found = SCRIPT.read_as(SpectralTable.load(v0_1_0.FOLDER / "diffraction" / "lobes.exr"))
    expected = v0_1_0.recorded("expected")["table"]
    assert found["atlas"] == expected["atlas"]
    for name in ("transform", "albedo"):
        assert found[name] == pytest.approx(np.array(expected[name]), rel=1e-6)


@pytest.fixture(scope="module")
def bakes():
    """What 0.1.0 took down, and the same of today's code."""

    def bake_as_then(*given):
        """Slices and albedos; what format 2 put above them is not of 0.1.0, which asked for no error of lookups, and
        balanced slice 1 for straight lookups on either side, where those below it follow 1 / |w| since.
        """
        scan, parameters = given
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(balance, "_FIRST", 1.0)
            table = bake(scan, replace(parameters, error=1.0))
        return SimpleNamespace(atlas=table.atlas[: table.layout.albedo_y + table.layout.albedo_height])

    return v0_1_0.recorded("bakes"), SCRIPT.bake_all(bake_as_then, make_preset, BakeParameters)


@pytest.mark.parametrize("name", SCRIPT.BAKES)
def test_a_bake_gives_the_same_texels(bakes, name):
    """To the last of a half float's 10 bits, and to the rounding of transforms in single precision of the brightest.

    The order in which transforms sum may change, and does between processors. What they sum may not, but for lags that
    weigh no more than 2.6e-5: which of them are left out hangs on the lengths of the transforms. That is one bit more
    where lags are weighted (3 texels of 360).
    """
    before, now = (each[name] for each in bakes)
    assert now["shape"] == before["shape"]
    texels = np.array(before["texels"])
    bits = 10 if name in ("single", "periodic") else 9
    assert np.array(now["texels"]) == pytest.approx(texels, rel=2.0**-bits, abs=1e-7 * texels.max())
