# SPDX-License-Identifier: GPL-3.0-or-later
"""The asset library: ready materials with catalogue and previews, at home in another file."""

import json
import os
import subprocess
import sys

import pytest

from tests.support.blender import extension

BUILD = """
import importlib.util, json, os, sys
from pathlib import Path
import bpy
import numpy as np
from tests.support.blender import extension, life
extension.load().register()
spec = importlib.util.spec_from_file_location("build_assets", sys.argv[1])
module = importlib.util.module_from_spec(spec)
sys.modules["build_assets"] = module
spec.loader.exec_module(module)
known = {item.identifier for item in bpy.context.scene.diffraction.bl_rna.properties["preset"].enum_items}
listed = {asset.preset for asset in module.ASSETS}
library = Path(sys.argv[2]) / "library" / "materials.blend"
(made,) = module.build_assets(library, only=("sinusoid",), detail=0.25, samples=1)
pixels = np.array(made.preview.image_pixels_float[:]).reshape(-1, 4)
found = {
    "unknown": sorted(listed - known), "name": made.name, "catalogue": made.asset_data.catalog_id,
    "description": made.asset_data.description, "tags": [tag.name for tag in made.asset_data.tags],
    "preview": [int(x) for x in made.preview.image_size], "brightest": float(pixels[:, :3].max()),
    "opaque": float((pixels[:, 3] > 0.5).mean()),
}
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.save_as_mainfile(filepath=str(Path(sys.argv[2]) / "mine.blend"))
with bpy.data.libraries.load(str(library), assets_only=True) as (there, into):
    into.materials = there.materials
found["appended"] = [material.name for material in into.materials]
found["states"], found["sockets"] = life.states(), life.sockets()
print("\\nRESULT" + json.dumps(found), flush=True)
os._exit(0)
"""


@pytest.mark.slow
def test_library_of_one_material(tmp_path):
    script = extension.ROOT / "sample_blend" / "build_assets.py"
    done = subprocess.run(
        [sys.executable, "-c", BUILD, str(script), str(tmp_path)],
        capture_output=True, text=True, cwd=extension.ROOT, check=False,
        env={**os.environ, "BLENDER_USER_RESOURCES": str(tmp_path / "user")},
    )  # fmt: skip
    lines = [line for line in done.stdout.splitlines() if line.startswith("RESULT")]
    assert lines, done.stdout + done.stderr
    found = json.loads(lines[-1].removeprefix("RESULT"))
    assert found["unknown"] == []
    assert found["name"] == "Sinusoidal Grating"
    catalogues = (tmp_path / "library" / "blender_assets.cats.txt").read_text()
    assert f"{found['catalogue']}:Diffraction/Gratings:" in catalogues
    assert found["description"] and "diffraction" in found["tags"]
    assert found["preview"] == [128, 128]
    assert found["brightest"] > 0.3 and 0.4 < found["opaque"] < 0.9  # a lit ball before nothing
    assert found["appended"] == ["Sinusoidal Grating"]
    assert found["states"] == {"Sinusoidal Grating": "READY"}
    assert found["sockets"] and all(there for _, there in found["sockets"].values())
