# SPDX-License-Identifier: GPL-3.0-or-later
"""Fuzz one or several readers in this process: ``python -m tests.support.trust.fuzz CASES FOLDER SEED NAME...``.

A process of its own, since a reader that crashes takes it along, and so that its address space can be
limited: 1 GiB above what it has once all libraries are loaded. A case that takes 5 s ends the process by SIGALRM.
The case at work is in ``FOLDER/case.*``; it stays there after a failure.
"""

import json
import resource
import signal
import sys
import time
from pathlib import Path

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as hypothesis_seed
from hypothesis import strategies as st

from precompute.errors import DiffractionError
from tests.support.trust import seeds
from tests.support.trust.mutations import ByHypothesis, ByRandom, changed, damaged, rejoined
from tests.support.trust.tables import small_scan, small_table

LIMIT_BYTES = 1 << 30
LIMIT_SECONDS = 5.0
BATCH = 20


def limit_memory(room=LIMIT_BYTES):
    """Let this process grow by ``room`` bytes and no more; None takes the limit away."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limit = resource.RLIM_INFINITY if room is None else pages * resource.getpagesize() + room
    resource.setrlimit(resource.RLIMIT_AS, (limit, resource.getrlimit(resource.RLIMIT_AS)[1]))


def check_refusal(error):
    """One printable sentence, and not one that hides that memory ran out."""
    text = str(error)
    assert text.endswith(".") and text.isprintable() and len(text) < 1000, repr(text)
    cause = error
    while cause is not None:
        assert not isinstance(cause, MemoryError), "more than 1 GiB was wanted"
        cause = cause.__cause__ or cause.__context__


def check_field(field):
    """What every computation takes for granted."""
    assert min(field.shape) >= 2
    assert np.isfinite(field.valid).all()
    assert all(np.isfinite(size) and size > 0 for size in (field.dx, field.dy))
    json.dumps([field.metadata, list(field.processing)], default=str)


class Runner:
    """Runs cases of one target, counts and times them."""

    def __init__(self, cases, seed):
        self.cases, self.seed = cases, seed
        self.counts = {"read": 0, "refused": 0}
        self.slowest = 0.0

    def run(self, make, attempt):
        """``attempt(make(chooser))`` for all cases; it may raise ``DiffractionError`` and nothing else.

        Of each ``BATCH`` cases Hypothesis makes one choice by choice and draws the random seed of the others.
        """

        @hypothesis_seed(self.seed)
        @settings(
            max_examples=-(-self.cases // BATCH),
            deadline=None,
            database=None,
            phases=[Phase.generate],
            suppress_health_check=list(HealthCheck),
        )
        @given(st.data(), st.integers(0, 2**64 - 1))
        def batch(data, number):
            self._one(make(ByHypothesis(data.draw)), attempt)
            choose = ByRandom(number)
            for _ in range(BATCH - 1):
                self._one(make(choose), attempt)

        batch()

    def _one(self, case, attempt):
        start = time.perf_counter()
        signal.setitimer(signal.ITIMER_REAL, LIMIT_SECONDS)  # its default action ends even a library in C
        try:
            attempt(case)
            self.counts["read"] += 1
        except DiffractionError as error:
            check_refusal(error)
            self.counts["refused"] += 1
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            self.slowest = max(self.slowest, time.perf_counter() - start)


def fuzz_reader(name, folder, runner):
    """A format's reader: its best channel, the names of all, and one other channel."""
    from precompute.readers import channel_names, read_scan

    seed = seeds.seeds(folder)[name]
    path = folder / f"case{seed.extension}"
    for good in seed.files:  # loads the libraries, and a seed that is refused would test nothing
        path.write_bytes(good)
        check_field(read_scan(path, **{**seeds.PICTURE, **seed.reading}))
    limit_memory()

    def make(choose):
        if seed.parts and choose.whole(0, 2):
            return rejoined(choose, seed.parts, seed.join)
        return damaged(choose, seed.files)

    def attempt(data):
        path.write_bytes(data)
        try:
            check_field(read_scan(path, **seed.reading))
        finally:
            last = len(channel_names(path)) - 1
            check_field(read_scan(path, channel=str(last), **seed.reading))

    runner.run(make, attempt)


def fuzz_table(name, folder, runner):
    """The table loader: damaged atlases, damaged sidecars, and well-formed ones that lie."""
    from precompute.files.exr import write_half_rgb
    from precompute.table.table import SpectralTable

    table = small_table(1, 12, 16)
    path = table.save(folder / "case.exr")
    atlas, text = path.read_bytes(), path.with_suffix(".json").read_bytes()
    rng = np.random.default_rng(0)
    w = -rng.uniform(0.0, 2.0, 50)
    u, v = rng.uniform(-1.4, 1.4, (2, 50))
    SpectralTable.load(path).transform(u, v, w)
    limit_memory()
    sidecar = json.loads(text)

    def make(choose):
        kind = choose.one_of(["atlas", "sidecar", "lie"])
        return kind, changed(choose, sidecar) if kind == "lie" else damaged(choose, [{"atlas": atlas}.get(kind, text)])

    def attempt(case):
        kind, value = case
        path.write_bytes(value if kind == "atlas" else atlas)
        path.with_suffix(".json").write_bytes(value if kind == "sidecar" else text)
        if kind == "lie":  # in both files, so that nothing contradicts it
            lie = json.dumps(value)
            path.with_suffix(".json").write_text(lie)
            write_half_rgb(path, table.atlas, lie)
        found = SpectralTable.load(path)
        assert found.transform(u, v, w).shape == (50, 3)
        assert isinstance(found.albedo_max, float)
        SpectralTable.load_atlas(path)

    runner.run(make, attempt)


def fuzz_terms(name, folder, runner):
    """The loader of series terms."""
    from precompute.bake.terms import load_terms, save_terms
    from precompute.parameters import BakeParameters

    terms = save_terms(small_scan(1, 8), BakeParameters(series="taylor", tolerance=0.1), folder / "case.exr")
    image = sorted(terms.glob("*.exr"))[0]
    pixels, text = image.read_bytes(), (terms / "terms.json").read_bytes()
    load_terms(terms)
    limit_memory()
    description = json.loads(text)

    def make(choose):
        kind = choose.one_of(["image", "text", "lie"])
        if kind == "lie":
            return kind, json.dumps(changed(choose, description)).encode()
        return kind, damaged(choose, [pixels if kind == "image" else text])

    def attempt(case):
        kind, value = case
        image.write_bytes(value if kind == "image" else pixels)
        (terms / "terms.json").write_bytes(text if kind == "image" else value)
        load_terms(terms)

    runner.run(make, attempt)


def fuzz_real(name, folder, runner):
    """A real file, by its path."""
    from precompute.readers import read_scan

    source = Path(name)
    path, good = folder / f"case{source.suffix}", source.read_bytes()
    reading = seeds.PICTURE if source.suffix == ".png" else {}
    path.write_bytes(good)
    try:
        check_field(read_scan(path, **reading))
    except DiffractionError as error:
        check_refusal(error)
    limit_memory()

    def attempt(data):
        path.write_bytes(data)
        check_field(read_scan(path, **reading))

    runner.run(lambda choose: damaged(choose, [good]), attempt)


def main(arguments):
    """Print one JSON object with an entry a target."""
    cases, folder, seed, *names = arguments
    results = {}
    for name in names:
        runner = Runner(int(cases), int(seed))
        target = {"table": fuzz_table, "terms": fuzz_terms}.get(name, fuzz_real if "/" in name else fuzz_reader)
        limit_memory(None)
        start = time.perf_counter()
        target(name, Path(folder), runner)
        results[name] = {
            **runner.counts,
            "slowest": round(runner.slowest, 4),
            "seconds": round(time.perf_counter() - start, 1),
        }
    print(json.dumps(results))


if __name__ == "__main__":
    main(sys.argv[1:])
