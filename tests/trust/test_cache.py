# SPDX-License-Identifier: GPL-3.0-or-later
"""The cache of tables: same bytes as a fresh bake, nothing stale, nothing damaged, never too large."""

import dataclasses
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from precompute.bake.baking import bake_file
from precompute.cli import main
from precompute.errors import OutputError, ParameterError
from precompute.parameters import BakeParameters
from precompute.scan.gsf import write_gsf
from precompute.scan.heightfield import HeightField
from precompute.table.cache import TableCache, table_key
from tests.support.trust.tables import small_scan, small_table

ROOT = Path(__file__).resolve().parents[2]
PARAMETERS = BakeParameters(sigma_s_m=0.5e-6, detail=0.5)


def files(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    return write_gsf(small_scan(1), tmp_path_factory.mktemp("scan") / "first.gsf")


def test_a_cached_table_is_the_baked_one_bit_for_bit(tmp_path, scan):
    cache = TableCache(tmp_path / "cache")
    plain = bake_file(scan, tmp_path / "plain", PARAMETERS)
    stored = bake_file(scan, tmp_path / "stored", PARAMETERS, cache=cache)
    hit = bake_file(scan, tmp_path / "hit", PARAMETERS, cache=cache)
    assert (plain.cache, stored.cache, hit.cache) == ("none", "stored", "hit")
    assert "transforms" not in hit.seconds
    assert files(tmp_path / "plain") == files(tmp_path / "stored") == files(tmp_path / "hit")


def test_the_path_does_not_matter_and_the_origin_is_told_anew(tmp_path, scan):
    """The same heights under another name hit, and the files are those of a fresh bake of that other file."""
    cache = TableCache(tmp_path / "cache")
    bake_file(scan, tmp_path / "first", PARAMETERS, cache=cache)
    other = tmp_path / "other.gsf"
    other.write_bytes(scan.read_bytes().replace(b"Title = Height", b"Title = Topo  "))
    fresh = bake_file(other, tmp_path / "fresh", PARAMETERS)
    hit = bake_file(other, tmp_path / "hit", PARAMETERS, cache=cache)
    assert hit.cache == "hit"
    assert files(tmp_path / "fresh") == files(tmp_path / "hit")
    assert fresh.table.info["source"]["channel"] == hit.table.info["source"]["channel"] == "Topo"


def test_everything_that_decides_a_table_decides_the_key():
    scan = small_scan(1)
    base = table_key(scan, PARAMETERS)
    assert base == table_key(small_scan(1), dataclasses.replace(PARAMETERS, limit_bytes=10**9))
    assert base == table_key(dataclasses.replace(scan, metadata={"name": "another"}), PARAMETERS)
    heights = scan.heights.copy()
    heights[3, 4] = np.nextafter(heights[3, 4], 1.0)
    missing = np.zeros(scan.shape, bool)
    missing[3, 4] = True
    changed = [
        table_key(dataclasses.replace(scan, heights=heights), PARAMETERS),
        table_key(dataclasses.replace(scan, missing=missing), PARAMETERS),
        table_key(dataclasses.replace(scan, dx=scan.dx * (1 + 1e-15)), PARAMETERS),
        table_key(dataclasses.replace(scan, dy=scan.dy * (1 + 1e-15)), PARAMETERS),
        table_key(HeightField(np.ascontiguousarray(scan.heights.T), scan.dx, scan.dy), PARAMETERS),
        *(
            table_key(scan, dataclasses.replace(PARAMETERS, **{name: value}))
            for name, value in {
                "sigma_s_m": 0.6e-6,
                "ensemble": "single",
                "series": "taylor",
                "tolerance": 1e-5,
                "level": "plane",
                "clip_percent": 99.0,
                "illuminant": "A",
                "detail": 1.0,
            }.items()
        ),
    ]
    assert len({base, *changed}) == 1 + len(changed)


def test_missing_points_hold_no_height():
    """Two fields that differ only in the numbers below the mask are one scan."""
    missing = np.zeros((4, 4), bool)
    missing[1, 2] = True
    one, two = np.zeros((4, 4)), np.zeros((4, 4))
    one[1, 2], two[1, 2] = np.nan, 1e-6
    keys = {table_key(HeightField(heights, 1e-8, 1e-8, missing), PARAMETERS) for heights in (one, two)}
    assert len(keys) == 1


@pytest.mark.parametrize("damage", ["pixels", "end", "header", "empty", "other"])
def test_a_damaged_entry_is_dropped_and_baked_again(tmp_path, damage):
    cache, table = TableCache(tmp_path), small_table(1)
    key = table.info["key"]
    assert cache.put(key, table)
    path = tmp_path / f"{key}.exr"
    data = bytearray(path.read_bytes())
    if damage == "pixels":
        data[-100] ^= 1
    elif damage == "end":
        del data[-1000:]
    elif damage == "header":
        data[:200] = bytes(200)
    elif damage == "empty":
        data.clear()
    else:  # another table under this name
        other = small_table(2)
        cache.put(other.info["key"], other)
        data[:] = (tmp_path / f"{other.info['key']}.exr").read_bytes()
    path.write_bytes(bytes(data))
    assert cache.get(key) is None
    assert not path.exists()
    cache.put(key, table)
    np.testing.assert_array_equal(cache.get(key).atlas, table.atlas)


def test_the_tables_used_longest_ago_go_first(tmp_path):
    tables = [small_table(number) for number in range(4)]
    keys = [table.info["key"] for table in tables]
    size = TableCache(tmp_path / "one").put(keys[0], tables[0]) and TableCache(tmp_path / "one").size_bytes()
    cache = TableCache(tmp_path / "cache", limit_bytes=int(3.5 * size))
    for key, table in zip(keys[:3], tables[:3], strict=True):
        cache.put(key, table)
    for age, key in enumerate(keys[:3]):
        os.utime(tmp_path / "cache" / f"{key}.exr", (1000.0 + age, 1000.0 + age))
    assert cache.get(keys[0]) is not None  # the oldest, used now
    cache.put(keys[3], tables[3])
    held = {path.stem for path in (tmp_path / "cache").iterdir()}
    assert held == {keys[0], keys[2], keys[3]}
    assert cache.size_bytes() <= cache.limit_bytes


def test_what_does_not_fit_is_not_stored(tmp_path):
    table = small_table(1)
    cache = TableCache(tmp_path, limit_bytes=table.atlas.nbytes - 1)
    assert not cache.put(table.info["key"], table)
    assert not list(tmp_path.iterdir())


def test_cleaning_touches_nothing_but_the_cache_s_own(tmp_path):
    table = small_table(1)
    mine = [tmp_path / "mine.exr", tmp_path / "notes.txt", tmp_path / "folder"]
    mine[0].write_bytes(b"picture")
    mine[1].write_bytes(b"text")
    mine[2].mkdir()
    left, fresh = tmp_path / ".tmp-0011223344556677.exr", tmp_path / ".tmp-8899aabbccddeeff.exr"
    left.write_bytes(b"half")
    fresh.write_bytes(b"of a process that is at work")
    os.utime(left, (1000.0, 1000.0))
    cache = TableCache(tmp_path)
    cache.put(table.info["key"], table)
    cache.clear()
    assert sorted(tmp_path.iterdir()) == sorted([*mine, fresh])


def test_a_cache_that_cannot_be_written_does_not_spoil_the_bake(tmp_path, scan, monkeypatch):
    def full(*_):
        raise OutputError("Cannot write: no space left on device.")

    cache = TableCache(tmp_path / "cache")
    monkeypatch.setattr("precompute.table.table.SpectralTable.save_atlas", full)
    report = bake_file(scan, tmp_path / "out", PARAMETERS, cache=cache)
    assert report.cache == "not stored"
    assert report.path.is_file()


def test_senseless_caches_are_refused(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(OutputError):
        TableCache(tmp_path / "file")
    with pytest.raises(ParameterError):
        TableCache(tmp_path, limit_bytes=0)


def test_two_processes_share_a_cache(tmp_path):
    """Both store, read and clean the same three tables for a while, with room for two: every read is whole."""
    program = """
import sys
import numpy as np
from precompute.table.cache import TableCache
from tests.support.trust.tables import small_table

tables = [small_table(n) for n in range(3)]
cache = TableCache(sys.argv[1], limit_bytes=int(2.5 * (tables[0].atlas.nbytes + 5000)))
rng = np.random.default_rng(int(sys.argv[2]))
hits = 0
for _ in range(150):
    table = tables[rng.integers(3)]
    found = cache.get(table.info["key"])
    if found is None:
        assert cache.put(table.info["key"], table)
    else:
        assert (found.atlas == table.atlas).all() and found.info == table.info
        hits += 1
print(hits)
"""
    processes = [
        subprocess.Popen([sys.executable, "-c", program, tmp_path, str(n)], cwd=ROOT, stdout=subprocess.PIPE, text=True)
        for n in range(2)
    ]
    hits = [int(process.communicate(timeout=60)[0]) for process in processes]
    assert all(process.returncode == 0 for process in processes)
    assert min(hits) > 10
    assert len(list(tmp_path.glob("*.exr"))) <= 3
    assert not list(tmp_path.glob(".tmp-*"))


def test_command_line(tmp_path, scan, monkeypatch, capsys):
    def bake(out, environment, *options):
        monkeypatch.setenv("DIFFRACTION_CACHE_DIR", environment)
        arguments = [
            "bake",
            str(scan),
            "--out",
            str(tmp_path / out),
            "--sigma-s-um",
            "0.5",
            "--detail",
            "0.5",
            "--json",
        ]
        assert main([*arguments, *options]) == 0
        return json.loads(capsys.readouterr().out)["cache"]

    folder = str(tmp_path / "cache")
    assert bake("a", "") == "none"
    assert bake("b", "", "--cache", folder) == "stored"
    assert bake("c", folder) == "hit"
    assert bake("d", folder, "--cache", "none") == "none"
    assert files(tmp_path / "a") == files(tmp_path / "b") == files(tmp_path / "c")
