# SPDX-License-Identifier: GPL-3.0-or-later
"""The arrow addon -> precompute, relative imports, and what an extension must never do, read from the sources."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
BLENDER = {"bpy", "bpy_extras", "bmesh", "gpu", "gpu_extras", "mathutils", "bl_ui", "blf", "aud", "idprop", "freestyle"}
HEAVY = {"scipy", "colour", "OpenEXR", "matplotlib", "tifffile", "threadpoolctl", "PIL"}
NETWORK = {"requests", "urllib", "http", "socket", "ftplib", "smtplib", "ssl", "xmlrpc", "pip", "ensurepip"}
OWN = {"addon", "precompute", "shaders", "sample_blend", "tests", "tools"}

PRECOMPUTE = sorted((ROOT / "precompute").rglob("*.py"))
ADDON = sorted((ROOT / "addon").rglob("*.py"))
SHIPPED = [ROOT / "__init__.py", *ADDON, *PRECOMPUTE]


def imports(tree):
    """(level, dotted name) of each import below a node; level 0 is an absolute one."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((0, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.level, node.module or ""


def imports_at_load(tree):
    """The same, but only of what runs when the module is loaded: not of function bodies."""
    nodes = list(tree.body)
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.Import | ast.ImportFrom):
            yield from imports(node)
        nodes.extend(ast.iter_child_nodes(node))


def absolute(found):
    """Top-level packages of the absolute imports among (level, name) pairs."""
    return {name.partition(".")[0] for level, name in found if level == 0}


def parse(path):
    return ast.parse(path.read_text(encoding="utf-8"), filename=str(path))


def label(path):
    return str(path.relative_to(ROOT))


def test_reading_imports_tells_load_from_call():
    tree = ast.parse(
        "import a.b\ntry:\n    from c import d\nexcept E:\n    pass\ndef f():\n    import scipy\nfrom . import e\n"
    )
    assert absolute(imports(tree)) == {"a", "c", "scipy"}
    assert absolute(imports_at_load(tree)) == {"a", "c"}


ONLY_FOR_TESTS = {"gwyfile", "gsffile", "meent", "pytest", "hypothesis"}


@pytest.mark.parametrize("path", SHIPPED, ids=label)
def test_only_bundled_libraries_are_used(path):
    assert not absolute(imports(parse(path))) & ONLY_FOR_TESTS


def test_there_are_sources_to_read():
    assert PRECOMPUTE
    assert ADDON


@pytest.mark.parametrize("path", PRECOMPUTE, ids=label)
def test_precompute_names_no_blender_module(path):
    assert not absolute(imports(parse(path))) & BLENDER
    assert not any(level > 0 and "addon" in name.split(".") for level, name in imports(parse(path)))


@pytest.mark.parametrize("path", SHIPPED, ids=label)
def test_own_modules_are_imported_relatively(path):
    """The extension is loaded as bl_ext.<repository>.diffraction_shader, where no absolute name of ours exists."""
    assert not absolute(imports(parse(path))) & OWN


@pytest.mark.parametrize("path", SHIPPED, ids=label)
def test_no_network_and_no_installing(path):
    assert not absolute(imports(parse(path))) & NETWORK


@pytest.mark.parametrize("path", SHIPPED, ids=label)
def test_sys_path_is_left_alone(path):
    touched = [
        node.lineno
        for node in ast.walk(parse(path))
        if isinstance(node, ast.Attribute)
        and node.attr in {"path", "path_hooks", "meta_path"}
        and isinstance(node.value, ast.Name)
        and node.value.id == "sys"
    ]
    assert not touched


@pytest.mark.parametrize("path", SHIPPED, ids=label)
def test_heavy_libraries_are_imported_inside_functions(path):
    assert not absolute(imports_at_load(parse(path))) & HEAVY


@pytest.mark.parametrize("path", [*SHIPPED, *sorted((ROOT / "tools").glob("*.py"))], ids=label)
def test_sources_carry_the_licence(path):
    assert path.read_text(encoding="utf-8").startswith("# SPDX-License-Identifier: GPL-3.0-or-later")


def test_every_precompute_module_loads_without_blender():
    """A subprocess in which Blender's modules cannot be found, and none of the heavy ones may have been loaded."""
    program = f"""
import importlib, pkgutil, sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {BLENDER!r}:
            raise ModuleNotFoundError(f"{{name}} is blocked")

sys.meta_path.insert(0, Refuse())
import precompute
names = [m.name for m in pkgutil.walk_packages(precompute.__path__, "precompute.") if not m.name.endswith("__main__")]
for name in names:
    importlib.import_module(name)
loaded = {HEAVY!r} & set(sys.modules)
assert not loaded, f"loaded with precompute: {{loaded}}"
print(len(names))
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    below = [path for path in PRECOMPUTE if path.name != "__main__.py" and path != ROOT / "precompute" / "__init__.py"]
    assert int(done.stdout) == len(below)


def test_shaders_carry_the_licence():
    shaders = [path for path in (ROOT / "shaders").rglob("*") if path.is_file()]
    assert [path for path in shaders if path.suffix == ".osl"]
    for path in shaders:
        assert path.read_text(encoding="utf-8").startswith("// SPDX-License-Identifier: GPL-3.0-or-later"), path
