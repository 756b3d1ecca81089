# SPDX-License-Identifier: GPL-3.0-or-later
"""Every snippet of the pages is run by a test, or stands here with the reason why not; command lines are parsed."""

import re
import shlex
from pathlib import Path

import pytest

from precompute.cli import build_parser

ROOT = Path(__file__).resolve().parents[2]
PAGES = (
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *sorted((ROOT / "docs" / "guide").glob("*.md")),
)

#: First words of what is not run: it needs what a test cannot bring.
NOT_RUN = {
    "dask scheduler": "a scheduler of its own on other machines; tests/trust/test_sweep.py sweeps on a local cluster",
    "blender --background scene.blend": "the program Blender; tests/addon/operators/test_files.py does the same by bpy",
    "deadlinecommand -SubmitCommandLineJob": "a render farm",
    "blender_manifest.toml": "a list of folders",
    "python -m precompute": "parsed below",
}


def blocks(page):
    """(language, text) of each fenced block."""
    return re.findall(r"^ *```(\w*)\n(.*?)^ *```$", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)


def commands():
    """Command lines of ours on all pages, without what the page leaves open in brackets."""
    for page in PAGES:
        for line in page.read_text(encoding="utf-8").splitlines():
            found = re.match(r" *(?:\.venv/bin/)?python -m precompute (.+)", line)
            if found:
                yield pytest.param(re.sub(r"\[.*?\]", "", found[1]), id=f"{page.name}: {found[1][:40]}")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_every_block_is_run_or_has_a_reason(page):
    """Python is run by tests/addon/docs/test_guide.py and test_pages.py, which take every block of that language."""
    others = [text for language, text in blocks(page) if language != "python"]
    assert [text for text in others if not text.startswith(tuple(NOT_RUN))] == []


@pytest.mark.parametrize("line", commands())
def test_the_command_line_is_understood(line):
    words = shlex.split(line)
    if "--help" in words:
        with pytest.raises(SystemExit) as stopped:
            build_parser().parse_args(words)
        assert stopped.value.code == 0
    else:
        assert build_parser().parse_args(words).command == words[0]


def test_there_are_commands_on_the_pages():
    assert len(list(commands())) > 3
