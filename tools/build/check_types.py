# SPDX-License-Identifier: GPL-3.0-or-later
"""mypy over both halves, as the package that Blender makes of them: `check_types.py [options of mypy]`.

The add-on imports relatively, out of its own folder, and the checkout's folder may have any name: so mypy reads a copy
in build/types, where

* the package is called `diffraction_shader`;
* `name: StringProperty(...)`, which is no annotation, reads `name: str = StringProperty(...)`, line by line the same;
* the types of Blender's Python know the properties that the extension registers, and what `blender_stub.py` adds.
"""

import ast
import importlib.metadata
import re
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path

from tools.build import blender_stub

ROOT = Path(__file__).resolve().parents[2]
COPY = ROOT / "build" / "types"
PACKAGE = "diffraction_shader"
STUBS = "fake-bpy-module-5.2"

#: Of its packages those that `blender_stub.py` amends.
AMENDED = ("bpy-stubs", "gpu-stubs", "mathutils-stubs")

#: What reading a property gives, by the function that declares it.
KINDS = {
    "BoolProperty": "bool",
    "BoolVectorProperty": "bpy.types.bpy_prop_array",
    "EnumProperty": "str",
    "FloatProperty": "float",
    "FloatVectorProperty": "bpy.types.bpy_prop_array",
    "IntProperty": "int",
    "IntVectorProperty": "bpy.types.bpy_prop_array",
    "StringProperty": "str",
}


def kind(call, known):
    """The type of what a property holds, as text; None where something else is called.

    Parameters
    ----------
    call : ast.expr
        What stands as the annotation.
    known : dict of str to ast.AST
        The project's classes, and its functions that return a property, by name.
    """
    if not isinstance(call, ast.Call):
        return None
    name = ast.unparse(call.func).rpartition(".")[2]
    given = {keyword.arg: keyword.value for keyword in call.keywords}
    if name in ("PointerProperty", "CollectionProperty"):
        what = ast.unparse(given["type"])
        what = what if what in known or what.startswith("bpy.types.") else "typing.Any"
        return what if name == "PointerProperty" else f"bpy.types.bpy_prop_collection_idprop[{what}]"
    if name == "EnumProperty" and "ENUM_FLAG" in ast.unparse(given.get("options", ast.Constant(""))):
        return "set[str]"
    if isinstance(known.get(name), ast.FunctionDef):
        return kind(known[name].body[-1].value, {})
    return KINDS.get(name)


def declared(sources):
    """The classes of all sources, and the functions that return a property: `def level(): return EnumProperty(...)`."""
    found = {}
    for source in sources:
        for node in ast.parse(source).body:
            if isinstance(node, ast.ClassDef):
                found[node.name] = node
            elif isinstance(node, ast.FunctionDef) and isinstance(node.body[-1], ast.Return):
                if kind(node.body[-1].value, {}):
                    found[node.name] = node
    return found


def typed(source, known):
    """The source with its properties as assignments, and the properties that it registers on Blender's classes."""
    tree = ast.parse(source)
    lines = source.split("\n")
    registered = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.AnnAssign) and node.value is None and (found := kind(node.annotation, known)):
            row, column = node.annotation.lineno - 1, node.annotation.col_offset
            lines[row] = f"{lines[row][:column]}{found} = {lines[row][column:]}"
        elif isinstance(node, ast.Assign) and (found := kind(node.value, known)):
            target = re.fullmatch(r"bpy\.types\.(\w+)\.(\w+)", ast.unparse(node.targets[0]))
            if target:
                registered.setdefault(target[1], {})[target[2]] = found
    return "\n".join(lines) + "import typing\n", registered


def sources():
    """The files of the copy with their texts, and the types of what is registered, by Blender's class and name."""
    halves = [path for half in ("addon", "precompute") for path in sorted((ROOT / half).rglob("*.py"))]
    texts = {path: path.read_text(encoding="utf-8") for path in (ROOT / "__init__.py", *halves)}
    known = declared(texts.values())
    copied, registered = {}, {}
    for path, text in texts.items():
        inside = Path(PACKAGE) / path.relative_to(ROOT)
        copied[inside], found = typed(text, known)
        module = ".".join(inside.with_suffix("").parts).removesuffix(".__init__")
        for cls, properties in found.items():
            for name, what in properties.items():
                own = re.search(rf"^class {what}\b", text, re.MULTILINE)
                registered.setdefault(cls, {})[name] = f"{module}.{what}" if own else what
    return copied, registered


def stubs(registered):
    """Blender's types, amended; mypy takes them before those in site-packages."""
    copied = {
        Path("bpy/ops/diffraction/__init__.pyi"): "import typing\n\ndef __getattr__(name: str) -> typing.Any: ...\n"
    }
    for file in importlib.metadata.files(STUBS) or []:
        package, *inside = file.parts
        if package not in AMENDED or file.suffix != ".pyi":
            continue
        name, text = file.as_posix(), file.read_text(encoding="utf-8")
        if name == "bpy-stubs/types/__init__.pyi":
            text, missing = blender_stub.amended(text, registered)
            if missing:
                sys.exit(f"{STUBS} has no {', '.join(missing)}: bring tools/build/blender_stub.py up to date.")
            ours = sorted({what for found in registered.values() for what in found.values() if "." in what})
            text = "".join(f"import {what.rpartition('.')[0]}\n" for what in ours) + text
        elif name == "bpy-stubs/ops/__init__.pyi":
            text += "\nfrom . import diffraction as diffraction\n"
        elif name == "bpy-stubs/props/__init__.pyi":
            text = text.replace(") -> _PropertyDeferred:", ") -> typing.Any:")
        for cls, lines in blender_stub.ADDED_ELSEWHERE.get(name, {}).items():
            text = blender_stub.with_lines(text, cls, lines)
        if inside[0] != "stub_internal":
            text = blender_stub.wider(text)
        copied[Path(package.removesuffix("-stubs"), *inside)] = text
    return copied


def write(copied):
    """Make build/types hold these files and no others; the same ones are left alone: mypy looks at their times."""
    for inside, text in copied.items():
        path = COPY / inside
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
    for path in COPY.rglob("*.py*"):
        if path.is_file() and path.relative_to(COPY) not in copied and ".mypy_cache" not in path.parts:
            path.unlink()


def main():
    copied, registered = sources()
    write(copied | stubs(registered))
    command = [sys.executable, "-m", "mypy", "--config-file", str(ROOT / "pyproject.toml"), "--package", PACKAGE]
    done = subprocess.run([*command, *sys.argv[1:]], cwd=COPY, capture_output=True, text=True, check=False)
    print(done.stdout.replace(f"{PACKAGE}/", ""), end="")
    print(done.stderr, end="", file=sys.stderr)
    sys.exit(done.returncode)


if __name__ == "__main__":
    main()
