# SPDX-License-Identifier: GPL-3.0-or-later
"""Enabling and disabling the add-on."""

import subprocess
import sys

import bpy

from tests.support.blender import extension


def test_register_imports_nothing_heavy():
    """In a process of its own, since tests import much."""
    code = (
        "import sys, bpy; from tests.support.blender import extension; extension.load().register();"
        "heavy = {'scipy', 'colour', 'matplotlib', 'OpenEXR', 'tifffile', 'gwyfile', 'PIL', 'pandas', 'h5py'};"
        "print('heavy:', sorted(heavy & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=extension.ROOT, capture_output=True, text=True, check=True)
    assert "heavy: []" in done.stdout


def test_disabling_leaves_nothing_behind(empty_blender):
    package = extension.load()
    handlers = {name: len(getattr(bpy.app.handlers, name)) for name in ("depsgraph_update_post", "load_post")}
    for _ in range(2):
        package.register()
        assert hasattr(bpy.context.scene, "diffraction")
        package.unregister()
    assert not hasattr(bpy.types.Scene, "diffraction")
    assert not hasattr(bpy.types, "DIFFRACTION_OT_bake")
    assert {name: len(getattr(bpy.app.handlers, name)) for name in handlers} == handlers
