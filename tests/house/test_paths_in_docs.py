# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that the pages name are there, under these names."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").rglob("*.md")])

#: A path from the checkout's root, in backticks or in a command: what begins with a folder of the sources.
FOLDERS = "addon|precompute|shaders|tests|tools|sample_blend|docs"
PATH = re.compile(rf"(?<![\w/.])((?:{FOLDERS})/[\w./-]*\w/?)(?![\w/]*[*{{<])")


def missing(text):
    """Paths in a text that lead nowhere."""
    return sorted({path for path in PATH.findall(text) if not (ROOT / path).exists()})


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_paths_lead_somewhere(page):
    assert missing(page.read_text(encoding="utf-8")) == []


def test_of_this_test():
    text = "`precompute/scan/levelling.py`, `addon/attic.py`, `shaders/{table,brdf}.osl`, out/tests/x, `tools/docs/`."
    assert missing(text) == ["addon/attic.py"]
