# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on switched on and off many times, and its cache with its preferences."""

import json
import subprocess
import sys

import numpy as np
import pytest

from tests.support.blender import extension
from tests.support.trust.tables import small_table

#: Cycles of enabling through Blender's own preferences; prints what is registered before and after, and memory.
CYCLES = """
import json, sys
import bpy, addon_utils
from tests.support.blender import extension

extension.loaded()
name, cycles = extension.NAME, int(sys.argv[1])

def state():
    handlers = {h: len(f) for h in dir(bpy.app.handlers) if isinstance(f := getattr(bpy.app.handlers, h), list)}
    return handlers, sorted(x for x in dir(bpy.types) if "diffraction" in x.lower()), sorted(bpy.types.Scene.bl_rna.properties.keys())

def resident():
    return next(int(l.split()[1]) for l in open("/proc/self/status") if l.startswith("VmRSS")) * 1024

before, memory = state(), []
for cycle in range(cycles):
    assert addon_utils.enable(name) is not None, cycle
    assert hasattr(bpy.context.scene, "diffraction")
    addon_utils.disable(name)
    assert not hasattr(bpy.context.scene, "diffraction")
    memory.append(resident())
print(json.dumps([before == state(), memory[len(memory) // 5], memory[-1]]))
"""  # noqa: E501


@pytest.mark.parametrize("cycles", [20, pytest.param(1000, marks=pytest.mark.slow)])
def test_enable_and_disable(cycles):
    done = subprocess.run(
        [sys.executable, "-c", CYCLES, str(cycles)], cwd=extension.ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-3000:]
    assert "Traceback" not in done.stderr and "Error" not in done.stderr, done.stderr[-3000:]
    same, early, late = json.loads(done.stdout.splitlines()[-1])
    print(cycles, early, late)
    assert same
    # Blender keeps some words of each registration; a kilobyte a class would be a leak that nobody notices.
    assert late - early < 100e3 * cycles


@pytest.fixture
def enabled(empty_blender, tmp_path, monkeypatch):
    """The add-on with preferences, its cache in a folder of the test."""
    import addon_utils

    extension.loaded()
    assert addon_utils.enable(extension.NAME, default_set=True) is not None
    module = sys.modules[f"{extension.NAME}.addon.preferences"]
    monkeypatch.setattr(module, "cache_folder", lambda: tmp_path / "cache")
    yield empty_blender, module, tmp_path / "cache"
    addon_utils.disable(extension.NAME, default_set=True)


def test_preferences_decide_on_the_cache(enabled):
    bpy, module, folder = enabled
    preferences = bpy.context.preferences.addons[extension.NAME].preferences
    assert preferences.keep_tables
    cache = module.table_cache()
    assert cache.folder == folder and cache.limit_bytes == preferences.cache_limit_mb * 1_000_000
    preferences.keep_tables = False
    assert module.table_cache() is None


def test_without_preferences_nothing_is_kept(enabled):
    bpy, module, _ = enabled
    bpy.context.preferences.addons.remove(bpy.context.preferences.addons[extension.NAME])
    assert module.table_cache() is None


def test_a_smaller_limit_and_the_button_make_room(enabled):
    bpy, module, folder = enabled
    preferences = bpy.context.preferences.addons[extension.NAME].preferences
    assert not bpy.ops.diffraction.clear_cache.poll()
    cache = module.table_cache()
    tables = [small_table(n, 200, 2000) for n in range(3)]
    for table in tables:
        cache.put(table.info["key"], table)
    assert 30e6 > cache.size_bytes() > 3 * tables[0].atlas.nbytes > 20e6
    preferences.cache_limit_mb = 22
    assert len(list(folder.iterdir())) == 2
    assert bpy.ops.diffraction.clear_cache() == {"FINISHED"}
    assert not list(folder.iterdir())


def test_the_operator_bakes_through_the_cache(enabled, tmp_path):
    """Two bakes of one scan write the same bytes, the second from the cache."""
    from precompute.scan.gsf import write_gsf
    from tests.support.trust.tables import small_scan

    bpy, _, folder = enabled
    scan = write_gsf(small_scan(1), tmp_path / "scan.gsf")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    assert bpy.ops.diffraction.import_scan(filepath=str(scan)) == {"FINISHED"}
    assert bpy.ops.diffraction.bake(sigma_s_um=0.5) == {"FINISHED"}
    (entry,) = folder.iterdir()
    atlas = tmp_path / "diffraction" / "scan.exr"
    first, used = atlas.read_bytes(), entry.stat().st_mtime_ns
    atlas.unlink()
    assert bpy.ops.diffraction.bake(sigma_s_um=0.5) == {"FINISHED"}
    assert atlas.read_bytes() == first
    assert entry.stat().st_mtime_ns > used and np.frombuffer(first[:4], "<u4")[0] == 20000630
