# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender 4.5 LTS beside 5.2 LTS: every source compiles for the older Python, and the smoke tests are there."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.smoke import SMOKE, is_smoke

ROOT = Path(__file__).resolve().parents[2]
SOURCES = [ROOT / "__init__.py", *sorted(p for d in ("addon", "precompute") for p in (ROOT / d).rglob("*.py"))]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: str(path.relative_to(ROOT)))
def test_the_source_is_python_3_11(path):
    ast.parse(path.read_text(encoding="utf-8"), feature_version=(3, 11))


def test_newer_syntax_would_be_told():
    with pytest.raises(SyntaxError):
        ast.parse("def first[T](values: list[T]) -> T: ...", feature_version=(3, 11))


@pytest.mark.parametrize("start", SMOKE)
def test_a_smoke_test_exists(start):
    path, _, name = start.partition("::")
    source = (ROOT / path).read_text(encoding="utf-8")
    assert f"def {name}(" in source if name else "def test_" in source


def test_names_are_compared_whole():
    assert is_smoke("tests/addon/test_register.py::test_anything")
    assert not is_smoke("tests/addon/test_register.py.bak")
    assert not is_smoke("tests/addon/materials/test_suns.py::test_sphere_under_one_sun_and_more")


def test_the_extension_says_what_this_blender_cannot_do(bpy_module):
    """Two sentences or more in 4.5, none in 5.2; in a process of its own, as nothing else may be registered."""
    program = (
        "from tests.support.blender import extension; extension.load()\n"
        "from diffraction_shader.addon import colour_spaces, versions\n"
        "print('\\nFOUND', len(versions.limits()), colour_spaces.working_space(), flush=True)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    found = [line for line in done.stdout.splitlines() if line.startswith("FOUND")]
    assert found, done.stderr
    _, count, space = found[0].split(maxsplit=2)
    assert space == "Linear Rec.709"
    assert (int(count) > 1) == (bpy_module.app.version < (5, 2))
