# SPDX-License-Identifier: GPL-3.0-or-later
"""`make types` reads the add-on as Blender does: properties have their values' types, registered ones are known."""

import subprocess
import sys
from pathlib import Path

import pytest

from tools.build import blender_stub, check_types

SOURCE = '''\
import bpy
from bpy.props import EnumProperty, FloatProperty, PointerProperty, StringProperty
def level():
    """A property for several classes."""
    return EnumProperty(
        items=(),
    )
class Group(bpy.types.PropertyGroup):
    name: StringProperty(
        name="Name"
    )
    size: FloatProperty(name="Size", min=0.0)
    level: level()
    flags: EnumProperty(items=(), options={"ENUM_FLAG"})
    other: int
bpy.types.Scene.ours = PointerProperty(type=Group)
'''


def test_properties_become_assignments_line_by_line():
    text, registered = check_types.typed(SOURCE, check_types.declared([SOURCE]))
    assert "    name: str = StringProperty(\n" in text
    assert "    size: float = FloatProperty(name" in text
    assert "    level: str = level()\n" in text
    assert "    flags: set[str] = EnumProperty(" in text
    assert "    other: int\n" in text
    assert text.split("\n")[: SOURCE.count("\n")] != SOURCE.split("\n")
    assert text.count("\n") == SOURCE.count("\n") + 1
    assert registered == {"Scene": {"ours": "Group"}}


STUB = '''\
class Scene(ID):
    """A scene"""

    @property
    def render(self) -> None | RenderSettings | None:
        """Settings"""

    @property
    def camera(self) -> Object | None:
        """May be missing"""

    @property
    def cycles(self) -> None | None:
        """Of Cycles"""

    engine: typing.Literal[
        "A", "B"
    ]

class Object(ID):
    data: (
        Mesh
        | None
    )
    name: str

class Other:
    pass
'''


@pytest.fixture
def tables(monkeypatch):
    """Small tables for the small stub."""
    monkeypatch.setattr(blender_stub, "NEVER_NONE", {"Scene": ("render",)})
    monkeypatch.setattr(blender_stub, "ANY", {"Object": ("data",)})
    monkeypatch.setattr(blender_stub, "ADDED", {})


def test_the_stub_is_amended(tables):
    text, missing = blender_stub.amended(STUB, {"Scene": {"ours": "ours.Group"}})
    assert missing == []
    assert "def render(self) -> RenderSettings:" in text
    assert "def camera(self) -> Object | None:" in text
    assert "class Scene(ID):\n    ours: ours.Group\n" in text
    assert "class Object(ID):\n    data: typing.Any\n    name: str\n" in text.replace("    )\n", "")
    assert "engine: str\n" in blender_stub.wider(text)


def test_a_line_that_outlived_its_use_is_named(tables, monkeypatch):
    monkeypatch.setattr(blender_stub, "NEVER_NONE", {"Scene": ("gone",), "NoSuchClass": ("layout",)})
    assert blender_stub.amended(STUB, {})[1] == ["NoSuchClass", "Scene.gone"]


@pytest.mark.slow
def test_a_fault_in_the_addon_is_found(tmp_path, monkeypatch):
    """A property that is a text is not a number; the sentence names the file and the line as they are."""
    root = check_types.ROOT
    copied, registered = check_types.sources()
    inside = Path(check_types.PACKAGE, "addon", "numbers.py")
    lines = copied[inside].count("\n")
    copied[inside] += "import bpy\ndef wrong() -> int:\n    return bpy.context.scene.diffraction.level\n"
    monkeypatch.setattr(check_types, "COPY", tmp_path / "copy")
    check_types.write(copied | check_types.stubs(registered))
    done = subprocess.run(
        [sys.executable, "-m", "mypy", "--config-file", str(root / "pyproject.toml"), "-p", check_types.PACKAGE],
        cwd=tmp_path / "copy", capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert f"addon/numbers.py:{lines + 3}: error: Incompatible return value type" in done.stdout, done.stdout
    assert "Found 1 error in 1 file" in done.stdout
