# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `paint` and the pictures that it reads."""

import json

import numpy as np
import pytest

from precompute.cli import main
from precompute.errors import ParameterError
from precompute.files.images import write_exr, write_png
from precompute.files.pictures import read_picture
from precompute.paint import load_paint, make_paint


def test_command_line_and_python_agree(tmp_path, capsys):
    picture = np.random.default_rng(1).uniform(0, 1, (20, 30, 3))
    write_png(tmp_path / "p.png", picture)
    words = ["paint", "picture", "--period-um", "1.6", "--picture", str(tmp_path / "p.png"), "--pixels", "60"]
    assert main([*words, "--lamp-deg", "40", "--out", str(tmp_path / "maps.exr"), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    stored = load_paint(tmp_path / "maps.exr")
    wanted = make_paint("picture", 1.6e-6, 60, pictures=[read_picture(tmp_path / "p.png")], lamp_deg=40)
    for one, other in zip(stored.maps, wanted.maps, strict=True):
        np.testing.assert_array_equal(one, other)
    assert told["shape"] == [40, 60] and told["marked"] == wanted.info["marked"]
    assert (told["scale_max"], told["depth_max"]) == pytest.approx(wanted.most)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["plaid", "--out", "x.exr"], "There is no recipe 'plaid'"),
        (["rings", "--out", "x.png"], "stored as .exr"),
        (["picture", "--out", "x.exr"], "takes one picture"),
        (["picture", "--picture", "none.png", "--out", "x.exr"], "does not exist"),
        (["rings", "--petals", "4", "--out", "x.exr"], "has no setting petals"),
    ],
)
def test_wrong_words_get_a_sentence_and_leave_nothing(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert main(["paint", *words, "--period-um", "2"]) == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_pictures_are_linear_and_the_right_way_up(tmp_path):
    """sRGB 188 is linear 0.503 (IEC 61966-2-1); row 0 is the bottom."""
    from PIL import Image

    values = np.zeros((2, 3, 4), np.uint8)
    values[0, 0] = (188, 0, 0, 255)  # top left
    values[1, 2] = (0, 255, 0, 128)  # bottom right, half there
    Image.fromarray(values).save(tmp_path / "p.png")
    seen = read_picture(tmp_path / "p.png")
    assert seen[1, 0, 0] == pytest.approx(0.5029, abs=1e-3)
    assert seen[0, 2, 1] == pytest.approx(128 / 255)
    assert np.count_nonzero(seen) == 2
    write_exr(tmp_path / "p.exr", seen)
    np.testing.assert_allclose(read_picture(tmp_path / "p.exr"), seen, atol=1e-6)
    (tmp_path / "broken.png").write_bytes(b"\x89PNG\r\n\x1a\n broken")
    with pytest.raises(ParameterError, match="cannot be read as a picture"):
        read_picture(tmp_path / "broken.png")
