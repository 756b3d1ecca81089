# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmarks rest on: medians and spreads, the warning on a busy machine, the older code beside this one."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tools.bench import machine, states

ROOT = Path(__file__).resolve().parents[2]


def test_spread_leaves_the_extremes_of_five_out():
    spread = machine.Spread([1.0, 9.0, 1.1, 0.2, 1.2])
    assert spread.median == 1.1
    assert spread.width == pytest.approx(0.2 / 1.1)
    assert spread.to_json() == {"median": 1.1, "least": 0.2, "most": 9.0, "rounds": 5}
    assert machine.Spread([2.0, 1.0]).width == pytest.approx(1.0 / 1.5)


@pytest.mark.parametrize(("others", "width", "quiet"), [(0.01, 0.02, True), (0.4, 0.02, False), (None, 0.5, False)])
def test_a_busy_machine_is_said_to_be_one(monkeypatch, capsys, others, width, quiet):
    monkeypatch.setattr(machine, "taken_by_others", lambda: others)
    spread = machine.Spread([1.0, 1.0, 1.0, 1.0 + width, 2.0])
    assert machine.warn_if_busy({"fft": spread, "copy": spread, "product": spread}) is quiet
    assert ("WARNING" in capsys.readouterr().out) is not quiet


def test_processes_of_the_older_code_import_that_code(tmp_path, monkeypatch):
    monkeypatch.setattr(states, "FOLDER", tmp_path)
    (tmp_path / "precompute").mkdir()
    (tmp_path / "precompute" / "__init__.py").write_text("print(__file__)\n")
    done = subprocess.run(
        [sys.executable, "-c", "import precompute"],
        cwd=tmp_path,
        env=states.environment(tmp_path),
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.strip() == str(tmp_path / "precompute" / "__init__.py")
    assert not (tmp_path / "precompute" / "__pycache__").exists()
    assert list((tmp_path / "compiled").rglob("*.pyc")), os.listdir(tmp_path)


def test_without_history_there_is_no_comparison(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(states, "FOLDER", tmp_path)
    monkeypatch.setattr(states, "BEFORE", "0" * 40)
    assert states.code_before() is None
    assert "No comparison" in capsys.readouterr().out
