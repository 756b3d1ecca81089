# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that makes the asset library: a second Blender is watched, stopped, and its library registered."""

import os
import sys

import bpy
import pytest

from tests.support.blender import extension

pytestmark = pytest.mark.usefixtures("blender")

#: Stands in for the second Blender, which the module has not.
BUILD = """
import os, sys
from pathlib import Path
import bpy
from tests.support.blender import extension
extension.load().register()
from diffraction_shader.addon.assets import library, worker
library.build_assets(Path(sys.argv[1]), only=("sinusoid",), detail=0.25, samples=1,
    progress=lambda name, fraction: print(f"{worker._MARK} {fraction:.3f} {name}", flush=True))
os._exit(0)
"""


@pytest.fixture
def stand_in(monkeypatch, tmp_path):
    """Start this instead of a second Blender."""
    from diffraction_shader.addon.assets import worker

    monkeypatch.setenv("PYTHONPATH", str(extension.ROOT))
    monkeypatch.setenv("BLENDER_USER_RESOURCES", str(tmp_path / "user"))

    def use(code):
        monkeypatch.setattr(
            worker, "command", lambda target, kind, only=(): [sys.executable, "-c", code, str(target), kind]
        )

    return use


def test_a_module_says_what_to_do():
    with pytest.raises(RuntimeError, match="build_assets"):
        bpy.ops.diffraction.make_asset_library()


@pytest.mark.slow
def test_the_library_is_made_and_registered_once(stand_in, tmp_path):
    stand_in(BUILD)
    libraries = bpy.context.preferences.filepaths.asset_libraries
    folder = tmp_path / "library"
    before = len(libraries)
    for _ in range(2):
        assert bpy.ops.diffraction.make_asset_library(directory=str(folder)) == {"FINISHED"}
    assert len(libraries) == before + 1 and libraries[-1].name == "Diffraction"
    assert os.path.samefile(libraries[-1].path, folder)
    with bpy.data.libraries.load(str(folder / "materials.blend"), assets_only=True) as (there, _):
        assert there.materials == ["Sinusoidal Grating"]
    assert (folder / "blender_assets.cats.txt").is_file()


def test_a_failure_is_told_and_nothing_registered(stand_in, tmp_path):
    stand_in("import sys; print('The disk is full'); sys.exit(3)")
    before = len(bpy.context.preferences.filepaths.asset_libraries)
    with pytest.raises(RuntimeError, match="The disk is full"):
        bpy.ops.diffraction.make_asset_library(directory=str(tmp_path / "library"))
    assert len(bpy.context.preferences.filepaths.asset_libraries) == before


def test_esc_ends_the_second_blender(stand_in):
    from diffraction_shader.addon.assets import worker
    from diffraction_shader.precompute.errors import Cancelled

    stand_in("import time\nprint('working', flush=True); time.sleep(60)")  # says nothing for long, as a bake does
    seen = []

    def stop(name, fraction):
        seen.append(name)
        if len(seen) > 3:
            raise Cancelled

    with pytest.raises(Cancelled):
        worker.run(worker.command(extension.ROOT, "OSL"), stop)
    assert len(seen) == 4


def test_only_some_materials_by_their_presets(stand_in, monkeypatch, tmp_path):
    from diffraction_shader.addon.assets import worker

    asked = []
    stand_in("print('no')")
    monkeypatch.setattr(
        worker, "command", lambda target, kind, only=(): asked.append(only) or [sys.executable, "-c", ""]
    )
    with pytest.raises(RuntimeError, match="no material of nonsense"):
        bpy.ops.diffraction.make_asset_library(directory=str(tmp_path), only="cd, nonsense")
    with pytest.raises(RuntimeError, match="could not be made"):
        bpy.ops.diffraction.make_asset_library(directory=str(tmp_path), only="cd, blazed")
    assert asked == [("cd", "blazed")]
