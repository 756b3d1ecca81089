# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line loads what a command needs and nothing else; faces of wings hand out their names on demand."""

import ast
import importlib
import subprocess
import sys
from pathlib import Path

import pytest

from precompute.bake import bake
from precompute.cli import build_parser, main
from precompute.commands import COMMANDS
from precompute.parameters import BakeParameters
from precompute.presets import make_preset

ROOT = Path(__file__).resolve().parents[3]
HEAVY = {"scipy", "colour", "matplotlib", "tifffile", "threadpoolctl"}


def loaded_by(*arguments):
    """Modules in a fresh Python after a command line."""
    program = (
        "import sys\nfrom precompute.cli import main\n"
        f"code = main({[str(a) for a in arguments]!r})\n"
        "print('LOADED', *sys.modules)\nsys.exit(code)"
    )
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.splitlines()[-1].split()[1:])


def test_help_loads_no_command_and_no_numpy():
    loaded = loaded_by("--help")
    assert not (HEAVY | {"numpy"}) & loaded
    assert not {name for name in loaded if name.startswith("precompute.commands.")}


def test_help_of_a_command_loads_that_one():
    loaded = loaded_by("info", "--help")
    assert {name for name in loaded if name.startswith("precompute.commands.")} == {
        "precompute.commands.info",
        "precompute.commands.options",
    }


def test_a_map_loads_nothing_that_bakes(tmp_path):
    path = bake(make_preset("sinusoid", 6e-6, 64), BakeParameters(detail=0.2)).save(tmp_path / "table.exr")
    loaded = loaded_by("map", path, "--theta-i", 30, "--phi-i", 0, "--size", 32, "--out", tmp_path / "map.png")
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")
    assert not HEAVY & loaded
    assert "precompute.bake.baking" not in loaded and "precompute.readers" not in loaded


def test_info_of_a_plain_scan_loads_no_heavy_library(tmp_path):
    from precompute.scan import write_gsf

    write_gsf(make_preset("sinusoid", 6e-6, 64), tmp_path / "a.gsf")
    assert not HEAVY & loaded_by("info", tmp_path / "a.gsf")


def test_the_list_of_commands_is_that_of_their_modules():
    folder = ROOT / "precompute" / "commands"
    found = {}
    for path in folder.glob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        if "add_arguments" in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}:
            found[path.stem] = ast.get_docstring(tree).splitlines()[0]
    assert found == COMMANDS


@pytest.mark.parametrize("name", COMMANDS)
def test_one_command_alone_parses_as_among_all(name):
    """Its help is the same, whichever way the parser was built."""

    def helped(parser):
        (subparsers,) = (action for action in parser._actions if hasattr(action, "choices") and action.choices)
        return subparsers.choices[name].format_help()

    assert helped(build_parser(name)) == helped(build_parser())


def test_an_unknown_command_is_named(capsys):
    assert main(["bakee"]) == 2
    assert "bakee" in capsys.readouterr().err


@pytest.mark.parametrize("wing", ["bake", "evaluate", "scan", "table"])
def test_a_face_hands_out_its_names(wing):
    face = importlib.import_module(f"precompute.{wing}")
    for name in face.__all__:
        assert getattr(face, name).__module__.startswith(f"precompute.{wing}."), name
        assert name in dir(face)
    with pytest.raises(AttributeError, match="nothing"):
        _ = face.nothing
    assert not hasattr(face, "annotations_that_are_not_there")
