# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests borrow from tests/support/ and tests/truth/, never from each other; so each can be moved, split or dropped."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
#: Imports as lines of code; those of the small programs in strings too, which only run in processes of their own.
LINE = re.compile(r"(?:^|[;\"'])\s*from (tests[\w.]*) import ([\w, ]+)", re.MULTILINE)


def borrowed(text):
    """Modules below tests/ that a source imports, in code or in a string, with the names it takes from each."""
    found = {
        (module, name.split(" as ")[0].strip()) for module, names in LINE.findall(text) for name in names.split(",")
    }
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "tests":
            found |= {(node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {(alias.name, "") for alias in node.names if alias.name.split(".")[0] == "tests"}
    return found


def faults(text, root=ROOT):
    """A sentence for each thing that is borrowed from a test or from nowhere."""
    found = []
    for module, name in sorted(borrowed(text)):
        path = root.joinpath(*module.split("."))
        source = path.with_suffix(".py")
        inside = path / f"{name}.py"
        if source.name.startswith("test_") or (name.startswith("test_") and inside.is_file()):
            found.append(f"{module} is a test: what others need of it belongs to tests/support/")
        elif source.is_file():
            if name and not re.search(
                rf"^(def |class |\w+, )*{name}\b", source.read_text(encoding="utf-8"), re.MULTILINE
            ):
                found.append(f"{module} has no {name}")
        elif not inside.is_file():
            found.append(f"there is no {module}.{name}")
    return found


@pytest.mark.parametrize("folder", ["tests", "tools", "sample_blend"])
def test_no_test_borrows_from_a_test(folder):
    found = [
        f"{path.relative_to(ROOT)}: {fault}"
        for path in sorted((ROOT / folder).rglob("*.py"))
        if path != Path(__file__)
        for fault in faults(path.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("from tests.support import compare\nfrom tests.support.compare import relative_error\n", None),
        ("def f():\n    from tests.house.test_floors import folders\n", "is a test"),
        ("from tests.house import test_floors\n", "is a test"),
        ("PROGRAM = '''\nimport sys\nfrom tests.support import nothing\n'''\n", "there is no tests.support.nothing"),
        ("PROGRAM = 'from tests.support.compare import absolute_error; print(1)'\n", "has no absolute_error"),
    ],
)
def test_of_this_test(text, said):
    found = faults(text)
    assert (said is None and found == []) or (len(found) == 1 and said in found[0])
