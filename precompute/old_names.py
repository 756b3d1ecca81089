# SPDX-License-Identifier: GPL-3.0-or-later
"""The dotted names of release 0.1.0 that its guides showed: they work for one more release, and say so.

Each stands in `sys.modules` as a module that hands out the names of the new one, with a DeprecationWarning at each
use; nothing is imported before. To be removed after the next release, together with its line in ``__init__.py``.
"""

import importlib
import sys
import warnings
from types import ModuleType
from typing import Any

#: Old name below this package -> the file that has its contents now. What the guides showed and still stands where it
#: stood (``bake``, ``parameters``, ``presets``) needs no line.
OLD_NAMES = {
    "brdf": "evaluate.surface",
    "directions": "evaluate.directions",
    "gsf": "scan.gsf",
    "illuminant": "light.illuminant",
}


class OldName(ModuleType):
    """A module under its old name."""

    def __init__(self, package: str, old: str, new: str) -> None:
        super().__init__(f"{package}.{old}", f"Old name of {package}.{new}.")
        self.__dict__["_new"] = f"{package}.{new}"

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # the import system asks for __spec__, __path__ and more
            raise AttributeError(name)
        new = self.__dict__["_new"]
        value = getattr(importlib.import_module(new), name)
        face = new.rpartition(".")[0]
        place = face if hasattr(sys.modules[face], name) else new
        warnings.warn(f"{self.__name__} is an old name: import {name} from {place}.", DeprecationWarning, stacklevel=2)
        return value


def install(package: str) -> None:
    """Make the old names of a package importable.

    Parameters
    ----------
    package
        Full name of this package, which differs where the add-on brings it.
    """
    for old, new in OLD_NAMES.items():
        name = f"{package}.{old}"
        if name not in sys.modules:
            module = OldName(package, old, new)
            sys.modules[name] = module
            setattr(sys.modules[package], old, module)
