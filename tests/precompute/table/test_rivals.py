# SPDX-License-Identifier: GPL-3.0-or-later
"""Two bakes of one name: one whole table stands in the end, and each process that was not alone says so."""

import pytest

from precompute.bake import baking
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.scan import write_gsf
from precompute.table.rivals import Rivals
from precompute.table.table import SpectralTable
from tests.support import tables_of_two

pytestmark = pytest.mark.filterwarnings("error")


@pytest.fixture
def two(tmp_path):
    """Two tables of one layout with keys, and a place for them."""
    return tables_of_two.tables(tmp_path), tmp_path / "t.exr"


def test_alone_there_is_nothing_to_say(two):
    (first, second), place = two
    assert Rivals(place).save(first) == (place, "")
    assert Rivals(place).save(second) == (place, "")  # a bake that comes later


def test_the_last_one_says_whose_place_it_took(two):
    (first, second), place = two
    slow, quick = Rivals(place), Rivals(place)
    assert quick.save(first)[1] == ""
    said = slow.save(second)[1]
    assert "Another process baked t.exr meanwhile; this table took its place" in said
    assert SpectralTable.load(place).info["key"] == second.info["key"]


def test_the_first_one_says_that_it_was_replaced(two, monkeypatch):
    """The other process renames between its writing and its look."""
    (first, second), place = two
    real = SpectralTable.save

    def save(table, path):
        written = real(table, path)
        real(second, path)
        return written

    monkeypatch.setattr(SpectralTable, "save", save)
    assert "wrote it last: its table stands there" in Rivals(place).save(first)[1]
    assert SpectralTable.load(place).info["key"] == second.info["key"]


def test_a_bake_notes_it(tmp_path, monkeypatch):
    scan = tmp_path / "scan.gsf"
    write_gsf(make_preset("sinusoid", 5e-6, 32), scan)
    parameters = BakeParameters(detail=0.25)
    assert baking.bake_file(scan, tmp_path, parameters, name="t").notes == ()
    real = baking._cached_bake

    def meanwhile(*arguments):
        (tmp_path / "t.exr").touch()
        return real(*arguments)

    monkeypatch.setattr(baking, "_cached_bake", meanwhile)
    report = baking.bake_file(scan, tmp_path, parameters, name="t")
    assert report.rival and report.rival in report.notes
