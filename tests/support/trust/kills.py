# SPDX-License-Identifier: GPL-3.0-or-later
"""Kill writers at random moments: ``python -m tests.support.trust.kills KIND POINTS FOLDER SEED``.

A store holds one of two states; a forked child writes the other and gets SIGKILL after a random time, from at once to
a little after it would be done. What is there afterwards must be the one state or the other, whole.
"""

import json
import os
import signal
import sys
import time
from pathlib import Path

import numpy as np

from precompute.files.atomic import TEMPORARY
from precompute.parameters import BakeParameters
from precompute.scan.heightfield import HeightField
from tests.support.trust.tables import small_scan, small_table


class Table:
    """Saving a table."""

    files = ("scan.exr", "scan.json")

    def __init__(self, folder):
        self.path, self.tables = folder / "scan.exr", [small_table(n, 100, 256) for n in range(2)]

    def write(self, state):
        self.tables[state].save(self.path)

    def read(self):
        from precompute.table.table import SpectralTable

        found = SpectralTable.load(self.path)
        (state,) = (n for n, t in enumerate(self.tables) if t.info == found.info and (t.atlas == found.atlas).all())
        return state


class Bake:
    """A whole bake, from reading the scan on; ``on_write`` hears when it begins to write."""

    files = ("scan.exr", "scan.json")

    def __init__(self, folder, series="nodes"):
        from precompute.scan.gsf import write_gsf

        self.folder, self.path = folder, folder / "scan.exr"
        self.scans = [write_gsf(small_scan(n, 32), folder.parent / f"scan{n}.gsf") for n in range(2)]
        self.parameters = BakeParameters(sigma_s_m=0.3e-6, detail=0.4, series=series, tolerance=0.01)
        self.tables = None
        self.on_write = None
        for state in (1, 0):
            self.write(state)
        self.tables = [self._fresh(state) for state in (0, 1)]

    def _bake(self, state, folder):
        from precompute.bake.baking import bake_file

        def progress(stage, fraction):
            if stage == "write" and self.on_write is not None:
                self.on_write()

        return bake_file(self.scans[state], folder, self.parameters, progress, name="scan")

    def _fresh(self, state):
        return self._bake(state, self.folder.parent / f"fresh{state}").table

    def write(self, state):
        self._bake(state, self.folder)

    def read(self):
        from precompute.table.table import SpectralTable

        found = SpectralTable.load(self.path)
        (state,) = (n for n, t in enumerate(self.tables) if t.info["key"] == found.info["key"])
        np.testing.assert_array_equal(found.atlas, self.tables[state].atlas)
        return state


class BakeWithTerms(Bake):
    """A bake that stores its series: the terms are whole and say which table they belong to."""

    files = ("scan.exr", "scan.json", "scan_terms")

    def __init__(self, folder):
        super().__init__(folder, "chebyshev")
        from precompute.bake.terms import load_terms

        self.terms = [load_terms(folder.parent / f"fresh{state}" / "scan_terms") for state in (0, 1)]

    def read(self):
        from precompute.bake.terms import load_terms

        found = load_terms(self.folder / "scan_terms")
        (state,) = (n for n, t in enumerate(self.terms) if t.key == found.key)
        np.testing.assert_array_equal(found.images, self.terms[state].images)
        return super().read()


class Import:
    """Storing an imported scan as .gsf."""

    files = ("scan.gsf",)

    def __init__(self, folder):
        rng = np.random.default_rng(0)
        self.path = folder / "scan.gsf"
        heights = [rng.standard_normal((700, 700)).astype(np.float32) * 1e-7 for _ in range(2)]
        self.fields = [
            HeightField(h, 1e-8 * (1 + n), 1e-8, metadata={"channel": f"{n}"}) for n, h in enumerate(heights)
        ]

    def write(self, state):
        from precompute.scan.gsf import write_gsf

        write_gsf(self.fields[state], self.path)

    def read(self):
        from precompute.readers import read_scan

        found = read_scan(self.path)
        state = int(found.metadata["channel"])
        np.testing.assert_array_equal(found.heights, self.fields[state].heights)
        assert found.dx == self.fields[state].dx
        return state


class Cache:
    """Storing in a cache that has room for one table: what `get` gives is right or nothing."""

    files = None

    def __init__(self, folder):
        from precompute.table.cache import TableCache

        self.tables = [small_table(n, 100, 256) for n in range(2)]
        self.cache = TableCache(folder, int(1.5 * self.tables[0].atlas.nbytes))

    def write(self, state):
        self.cache.put(self.tables[state].info["key"], self.tables[state])

    def read(self):
        held = {}
        for state, table in enumerate(self.tables):
            path = self.cache.folder / f"{table.info['key']}.exr"
            stored = path.stat().st_mtime_ns if path.exists() else 0
            hit = self.cache.get(table.info["key"])
            if hit is not None:
                assert hit.info == table.info
                np.testing.assert_array_equal(hit.atlas, table.atlas)
                held[stored] = state
        return held[max(held)]


KINDS = {"table": Table, "bake": Bake, "terms": BakeWithTerms, "import": Import, "cache": Cache}


def child(store, state, pipe=None):
    """Fork a writer of ``state``; it says on ``pipe`` when it begins to write."""
    pid = os.fork()
    if pid:
        return pid
    code = 1
    try:
        if pipe is not None:
            store.on_write = lambda: os.write(pipe, b"w")
        store.write(state)
        code = 0
    finally:
        os._exit(code)


def durations(store):
    """Seconds of a whole write, and of its part after the signal that writing begins."""
    reading, writing = os.pipe()
    start = time.perf_counter()
    pid = child(store, 0, writing)
    late = None
    if isinstance(store, Bake):
        os.read(reading, 1)
        late = time.perf_counter()
    assert os.waitpid(pid, 0)[1] == 0
    end = time.perf_counter()
    os.close(reading)
    os.close(writing)
    return end - start, None if late is None else end - late


def run(kind, points, folder, seed):
    """How often the old state was found, and how often the new one."""
    folder = Path(folder) / "store"
    folder.mkdir(parents=True)
    store, rng = KINDS[kind](folder), np.random.default_rng(seed)
    store.write(0)
    assert store.read() == 0
    times = [durations(store) for _ in range(3)]
    whole = float(np.median([time for time, _ in times]))
    late = None if times[0][1] is None else float(np.median([time for _, time in times]))
    state, found = 0, {"old": 0, "new": 0}
    for point in range(points):
        reading, writing = os.pipe()
        pid = child(store, 1 - state, writing)
        # Every second bake dies while it writes, which is a small part of it.
        if late is not None and point % 2:
            os.read(reading, 1)
            delay = late
        else:
            delay = whole
        time.sleep(float(rng.uniform(0.0, 1.5)) * delay)
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
        os.close(reading)
        os.close(writing)
        now = store.read()
        found["old" if now == state else "new"] += 1
        state = now
        rest = {path.name for path in folder.iterdir() if not path.name.startswith(TEMPORARY)}
        assert store.files is None or rest == set(store.files), rest
        for path in folder.rglob(f"{TEMPORARY}*"):
            path.unlink()
    return {"points": points, **found, "seconds": whole}


if __name__ == "__main__":
    kind, points, folder, seed = sys.argv[1:]
    print(json.dumps(run(kind, int(points), folder, int(seed))))
