# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces of wings that load a file when a name of it is asked for.

Importing one file of a wing runs the wing's ``__init__.py``. Were that to import all the others, a command that looks
something up in a table would load everything that bakes one. So a face writes its imports under ``TYPE_CHECKING``,
where editors, type checkers and the floors of the house read them, and hands the names out on demand.
"""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any


def on_demand(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """A face's ``__getattr__`` and ``__dir__`` (PEP 562).

    Parameters
    ----------
    package
        The face's ``__name__``. Its imports stand in its block ``if TYPE_CHECKING:``.
    """

    def get(name: str) -> Any:
        face = sys.modules[package]
        if name.startswith("__") or name not in face.__all__:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        module, original = _imports(str(face.__file__))[name]
        value = getattr(importlib.import_module(f".{module}", package), original)
        setattr(face, name, value)
        return value

    def names() -> list[str]:
        face = sys.modules[package]
        return sorted({*vars(face), *face.__all__})

    return get, names


def _imports(path: str) -> dict[str, tuple[str, str]]:
    """Name -> file and name in it, of the relative imports under ``TYPE_CHECKING`` in a source file."""
    import ast

    tree = ast.parse(Path(path).read_text(encoding="utf-8"), path)
    blocks = [
        node.body
        for node in tree.body
        if isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    ]
    return {
        alias.asname or alias.name: (node.module or "", alias.name)
        for block in blocks
        for node in block
        if isinstance(node, ast.ImportFrom) and node.level == 1
        for alias in node.names
    }
