# SPDX-License-Identifier: GPL-3.0-or-later
"""What a failing picture leaves behind, and what is never let pass."""

import matplotlib.image
import numpy as np
import pytest

from tests.support import compare


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where pictures of failures go, for once."""
    monkeypatch.setattr(compare, "OUT", tmp_path / "failed")
    return tmp_path / "failed"


def pair():
    """A reference that grows upwards, and a result that is wrong in its bottom left corner."""
    reference = np.repeat(np.linspace(0.1, 1.0, 16)[:, None, None], 16, 1).repeat(3, 2)
    result = reference.copy()
    result[:4, :4] *= 2.0
    return result, reference


def test_three_pictures_show_where_it_is_wrong(folder):
    result, reference = pair()
    with pytest.raises(AssertionError, match="patch: relative error 1 "):
        compare.assert_images_agree(result, reference, 0.01, name="patch")
    shown = {kind: matplotlib.image.imread(folder / f"patch_{kind}.png")[..., :3] for kind in ("reference", "result")}
    error = matplotlib.image.imread(folder / "patch_error.png")[..., :3]
    assert len(list(folder.iterdir())) == 3
    # Row 0 of a file is the top: the reference is brightest there, the error stands at the bottom left.
    assert shown["reference"][0].mean() > shown["reference"][-1].mean() + 0.3
    differs = (shown["reference"] != shown["result"]).any(-1)
    assert differs[-4:, :4].all()
    assert differs.sum() == 16
    assert (error[-1, 0] != error[0, -1]).any()
    assert (error[-4:, :4] == error[-1, 0]).all()


def test_pictures_that_agree_leave_nothing(folder):
    _, reference = pair()
    compare.assert_images_agree(reference * 1.001, reference, 0.01)
    assert not folder.exists()


def test_a_value_that_is_no_number_fails(folder):
    result, reference = pair()
    result[:] = np.nan
    with pytest.raises(AssertionError, match="nan"):
        compare.assert_images_agree(result, reference, 0.01)


def test_no_pixel_to_compare_fails(folder):
    result, reference = pair()
    with pytest.raises(AssertionError, match="no pixel"):
        compare.assert_images_agree(result, reference, 0.01, where=np.zeros((16, 16), bool))
