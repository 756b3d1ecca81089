# SPDX-License-Identifier: GPL-3.0-or-later
"""All processing from one set of parameters."""

import numpy as np
import pytest

from precompute.errors import ParameterError
from precompute.parameters import BakeParameters
from precompute.scan.heightfield import HeightField
from precompute.scan.preparation import prepare


@pytest.fixture
def field():
    """A tilted sine with its lines offset, a spike, and pixels fine enough to need no refining."""
    x, _ = np.meshgrid((np.arange(120) + 0.5) * 50e-9, (np.arange(100) + 0.5) * 50e-9)
    heights = 30e-9 * np.sin(2 * np.pi * x / 0.55e-6) + 0.01 * x
    heights += np.random.default_rng(1).normal(0.0, 5e-9, 100)[:, None]
    heights[50, 60] = 1e-6
    return HeightField(heights, 50e-9, 50e-9)


def test_nothing_is_done_by_default(field):
    patch = prepare(field, BakeParameters())
    assert np.array_equal(patch.heights, field.heights)
    assert patch.processing == ()


def test_every_step_in_its_order(field):
    parameters = BakeParameters(
        crop_m=(0.0, 5e-6, 1e-6, 5e-6), level="plane", align_rows="x", clip_percent=99.9, smooth_m=60e-9, tile="blend"
    )
    patch = prepare(field, parameters)
    assert [step["step"] for step in patch.processing][:6] == ["crop", "level", "align rows", "clip", "smooth", "tile"]
    assert patch.size_m[0] < 5e-6 and patch.size_m[1] < 4e-6
    # The lines' offsets and the spike are gone, the sine is there: 30 nm less what the Gaussian takes.
    kept = 30e-9 * np.exp(-0.5 * (2 * np.pi * 60e-9 / 0.55e-6) ** 2)
    assert np.sqrt(2.0) * patch.heights[:, 10:-10].std() == pytest.approx(kept, rel=0.1)


def test_whole_periods(field):
    patch = prepare(field, BakeParameters(level="plane", align_rows="x", clip_percent=99.5, tile="period"))
    periods = patch.size_m[0] / 0.55e-6
    assert periods == pytest.approx(round(periods), abs=0.02)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"align_rows": "z"}, "row alignment"),
        ({"tile": "mirror"}, "tiling"),
        ({"smooth_m": -1e-9}, "Smoothing"),
        ({"smooth_m": float("nan")}, "Smoothing"),
        ({"crop_m": (1e-6, 0.0, 0.0, 1e-6)}, "crop"),
        ({"crop_m": (0.0, 1e-6)}, "crop"),
        ({"crop_m": (0.0, float("inf"), 0.0, 1e-6)}, "crop"),
    ],
)
def test_nonsense_is_refused(wrong, words):
    with pytest.raises(ParameterError, match=words):
        BakeParameters(**wrong)


def test_a_crop_beside_the_patch_is_refused(field):
    with pytest.raises(ParameterError):
        prepare(field, BakeParameters(crop_m=(1e-3, 2e-3, 1e-3, 2e-3)))
