# SPDX-License-Identifier: GPL-3.0-or-later
"""`check` and what `info` says of a table."""

import json

import pytest

from precompute.cli import main
from tests.support import tables_of_two


@pytest.fixture
def folder(tmp_path):
    tables_of_two.tables(tmp_path)
    return tmp_path / "made"


def test_whole_tables(folder, capsys):
    assert main(["check", str(folder)]) == 0
    assert capsys.readouterr().out == "2 tables, 0 with faults\n"


@pytest.mark.parametrize("damage", ["cut", "no sidecar", "no atlas"])
def test_a_fault_ends_with_1(folder, capsys, damage):
    atlas = folder / "first.exr"
    if damage == "cut":
        atlas.write_bytes(atlas.read_bytes()[:-200])
    else:
        atlas.with_suffix(".json" if damage == "no sidecar" else ".exr").unlink()
    assert main(["check", str(atlas), str(folder / "second.exr"), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["tables"] == 2 and list(found["faults"]) == [str(atlas)]


def test_info_of_a_table_says_what_became_of_its_energy(tmp_path, capsys):
    from precompute.bake.baking import bake
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    table = bake(make_preset("blazed", 10e-6, 64), BakeParameters(detail=0.25))
    table.save(tmp_path / "t.exr")
    energy = table.info["energy"]
    assert 0.0 <= energy["share_lost"] < 1.0
    assert main(["info", str(tmp_path / "t.exr")]) == 0
    text = capsys.readouterr().out
    assert f"{100 * energy['share_cut']:.1f} % of even light is cut" in text
    assert f"{100 * energy['share_lost']:.1f} % is lost on steep sides and not refilled" in text
    assert main(["info", str(tmp_path / "t.exr"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["energy"] == energy


def test_the_share_lost_of_known_albedos():
    """Of a black surface all, of a white one nothing, of a half-grey one half."""
    import numpy as np

    from precompute.table.facts import lost_share

    for albedo, share in ((0.0, 1.0), (1.0, 0.0), (1.4, 0.0), (0.5, 0.5)):
        assert lost_share(np.full((4, 46), albedo)) == pytest.approx(share)
