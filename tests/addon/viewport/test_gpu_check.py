# SPDX-License-Identifier: GPL-3.0-or-later
"""The command that compares devices: what it lets pass, and that it sees a device that is wrong."""

import numpy as np
import pytest

from tools import gpu_check


def pictures(seed=0):
    rng = np.random.default_rng(seed)
    return rng.uniform(0.5, 1.0, (16, 16, 3))


def test_equal_pictures_agree():
    reference = pictures()
    assert gpu_check.compare("gpu", "what", reference, reference, 0.01, 0.001).agrees


@pytest.mark.parametrize("fault", ["dark", "spots", "hole", "swapped"])
def test_faults_are_seen(fault):
    reference = pictures()
    found = reference.copy()
    if fault == "dark":
        found *= 0.97
    elif fault == "spots":
        found[::5, ::5] *= 3.0  # 16 of 256 pixels
    elif fault == "hole":
        found[3, 4] = np.nan
    else:
        found = found[..., ::-1]
    row = gpu_check.compare("gpu", "what", found, reference, 0.05, 0.01)
    assert not row.agrees
    assert "DIFFERS" in row.text()


def test_a_single_pixel_at_the_rim_is_no_fault():
    reference = pictures()
    found = reference.copy()
    found[0, 0] *= 1.5
    assert gpu_check.compare("gpu", "what", found, reference, 0.05, 0.01).agrees


def test_wrong_arguments_end_with_2(capsys):
    with pytest.raises(SystemExit) as ended:
        gpu_check.main(["--size", "13"])
    assert ended.value.code == 2
    assert "multiple of 8" in capsys.readouterr().err


def test_the_viewport_and_a_bake_agree_with_the_processor(blender, tmp_path):
    check = gpu_check.Check(16, 4, tmp_path)
    rows = [*check.bake()]
    assert [row.what for row in rows] == ["bake against processor"]
    assert all(row.agrees for row in rows)
