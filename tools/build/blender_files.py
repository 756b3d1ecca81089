# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the files of Blender are that the build uses, found in the bpy wheel without starting Blender."""

import importlib.util
import runpy
import sys
from pathlib import Path


def _scripts():
    spec = importlib.util.find_spec("bpy")
    if spec is None or not spec.submodule_search_locations:
        sys.exit("Blender as a module is missing: run `make setup`.")
    return next(Path(spec.submodule_search_locations[0]).glob("*/scripts"))


def extension_tool():
    """Path of Blender's own `blender_ext.py`, which builds and validates extensions."""
    return _scripts() / "addons_core" / "bl_pkg" / "cli" / "blender_ext.py"


def valid_tags():
    """The tags that Blender knows for add-ons, as a set of strings."""
    return set(runpy.run_path(str(_scripts() / "modules" / "_bpy_internal" / "extensions" / "tags.py"))["addons"])
