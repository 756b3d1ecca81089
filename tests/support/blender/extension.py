# SPDX-License-Identifier: GPL-3.0-or-later
"""The checkout as the package that Blender would make of it, since the add-on imports relatively."""

import importlib.util
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
NAME = "diffraction_shader"


def load():
    """The package `diffraction_shader`, imported from the checkout."""
    if NAME not in sys.modules:
        spec = importlib.util.spec_from_file_location(
            NAME, ROOT / "__init__.py", submodule_search_locations=[str(ROOT)]
        )
        module = importlib.util.module_from_spec(spec)
        sys.modules[NAME] = module
        spec.loader.exec_module(module)
    return sys.modules[NAME]


def give_nodes(block):
    """The nodes of a new material or world: Blender 4.5 makes them only on request."""
    if block.node_tree is None:
        block.use_nodes = True
    return block.node_tree


def loaded():
    """The package as Blender remembers one that it has loaded: otherwise it looks for it to load it again."""
    package = load()
    package.__time__ = os.path.getmtime(package.__file__)
    package.__addon_enabled__ = False
    return package
