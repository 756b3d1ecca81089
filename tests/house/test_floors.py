# SPDX-License-Identifier: GPL-3.0-or-later
"""The floors of the house: no import climbs, no circle, faces that load alone, old names that still answer."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tools import house

ROOT = Path(__file__).resolve().parents[2]
WINGS = ("light", "files", "scan", "readers", "presets", "table", "bake", "evaluate")
HEAVY = ("scipy", "colour", "matplotlib", "OpenEXR", "tifffile", "bpy")
LIMIT_MODULES = 16


@pytest.mark.parametrize("half", sorted(house.FLOORS))
def test_no_import_climbs(half):
    assert house.floor_faults(half) == []


@pytest.mark.parametrize("half", sorted(house.FLOORS))
def test_no_circles(half):
    assert house.circles(half) == []


@pytest.fixture
def copied(tmp_path):
    """The sources of both halves, to be spoilt."""
    for half in house.FLOORS:
        shutil.copytree(ROOT / half, tmp_path / half, ignore=shutil.ignore_patterns("__pycache__"))
    return tmp_path


def test_an_arrow_turned_round_is_named(copied):
    """A face of the scans that asks for a bake: inside a function, too."""
    path = copied / "precompute" / "scan" / "levelling.py"
    path.write_text(path.read_text() + "\n\ndef f():\n    from ..bake.baking import bake\n    return bake\n")
    (fault,) = house.floor_faults("precompute", copied)
    assert "precompute/scan/levelling.py" in fault and "precompute/bake/baking.py" in fault
    assert house.floor_faults("addon", copied) == []


def test_a_circle_is_named(copied):
    path = copied / "addon" / "materials" / "travel.py"
    path.write_text(path.read_text() + "\n\ndef f():\n    from . import material\n    return material\n")
    circle = next(c for c in house.circles("addon", copied) if len(c) == 2)
    assert sorted(circle) == ["addon/materials/material.py", "addon/materials/travel.py"]


def test_a_file_without_a_floor_is_named(copied):
    (copied / "precompute" / "attic.py").write_text("")
    assert house.floor_faults("precompute", copied) == ["precompute/attic.py stands on no floor"]


def folders():
    """Every folder of sources, and how many modules it holds."""
    for half in ("precompute", "addon", "tools"):
        for folder in [ROOT / half, *sorted(p for p in (ROOT / half).rglob("*") if p.is_dir())]:
            if count := len(list(folder.glob("*.py"))):
                yield str(folder.relative_to(ROOT)), count


def test_no_folder_is_crowded():
    assert [each for each in folders() if each[1] > LIMIT_MODULES] == []


def fresh(program, *options):
    done = subprocess.run(
        [sys.executable, *options, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


CHECK = """
face = sys.modules["precompute.{wing}"]
from pathlib import Path
from types import ModuleType
files = {{path.stem for path in Path(face.__file__).parent.iterdir() if path.suffix == ".py" or path.is_dir()}}
assert face.__doc__ and len(face.__doc__.split()) > 20, "a face says what happens here"
for name in face.__all__:
    assert name not in files, f"{{name}} is the name of a file too"
    assert not isinstance(getattr(face, name), ModuleType), name
heavy = {heavy!r}
assert not set(heavy) & set(sys.modules), set(heavy) & set(sys.modules)
"""


@pytest.mark.parametrize("order", ["face first", "files first"])
@pytest.mark.parametrize("wing", WINGS)
def test_a_face_loads_alone(wing, order):
    names = [name for name in house.modules("precompute") if name.startswith(f"precompute.{wing}.")]
    imports = [f"import precompute.{wing}", *(f"import {name}" for name in names)]
    if order == "files first":
        imports.reverse()
    check = CHECK.format(wing=wing, heavy=HEAVY)
    fresh("import sys\n" + "\n".join(imports) + check)


#: What the guides of 0.1.0 imported.
OF_0_1_0 = (
    ("bake", "bake", None),
    ("bake", "bake_file", None),
    ("brdf", "brdf", "precompute.evaluate"),
    ("directions", "from_angles", "precompute.evaluate"),
    ("gsf", "write_gsf", "precompute.scan"),
    ("illuminant", "read_spectrum", "precompute.light"),
    ("parameters", "BakeParameters", None),
    ("presets", "make_preset", None),
)


@pytest.mark.parametrize(("module", "name", "place"), OF_0_1_0)
def test_names_of_0_1_0(module, name, place):
    """They give the same object and, where they moved, say once where it is now."""
    said = fresh(
        "import warnings\n"
        "with warnings.catch_warnings(record=True) as caught:\n"
        "    warnings.simplefilter('always')\n"
        f"    from precompute.{module} import {name}\n"
        f"assert callable({name}) and {name}.__name__ == {name!r}\n"
        "print([(w.category.__name__, str(w.message)) for w in caught])"
    )
    if place is None:
        assert said.strip() == "[]"
    else:
        assert re.search(rf"DeprecationWarning.*import {name} from {re.escape(place)}\.", said), said


def test_old_modules_as_attributes():
    said = fresh("import precompute\nprint(precompute.directions.uvw.__name__)", "-W", "ignore")
    assert said.strip() == "uvw"
    wrong = "import precompute\ntry:\n    precompute.gsf.nothing\nexcept AttributeError as error:\n    print(error)"
    assert "nothing" in fresh(wrong)
