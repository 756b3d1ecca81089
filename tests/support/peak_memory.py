# SPDX-License-Identifier: GPL-3.0-or-later
"""How much memory a piece of code takes at its peak, whatever this process took before."""

from pathlib import Path

import pytest


class PeakMemory:
    """Context manager; afterwards `grown` is the peak resident memory in bytes above what was there at the start.

    Linux only (elsewhere the test is skipped): the peak that getrusage tells never falls, so after one large test
    it would neither pass where it should nor fail where it should.
    """

    def __enter__(self):
        if not Path("/proc/self/clear_refs").exists():
            pytest.skip("the peak of this process's memory can be reset on Linux only")
        Path("/proc/self/clear_refs").write_text("5")  # sets the peak to what is resident now, see proc(5)
        self._before = self._peak()
        return self

    def __exit__(self, *_):
        self.grown = self._peak() - self._before

    @staticmethod
    def _peak():
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) * 1024 for line in lines if line.startswith("VmHWM"))
