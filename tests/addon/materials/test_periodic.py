# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of one period as a material: the operator bakes what Python bakes, and a material takes the table."""

import bpy
import pytest

pytestmark = pytest.mark.usefixtures("blender")


def test_operator_bakes_copies_of_a_period(blender, tmp_path):
    from precompute.bake.baking import bake_file
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset
    from precompute.scan.gsf import write_gsf
    from precompute.table.table import SpectralTable

    folder = tmp_path / "project"
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    tile = write_gsf(make_preset("blazed", 1e-6, 16, period_um=1.0, depth_nm=150), tmp_path / "tile.gsf")
    bpy.ops.diffraction.import_scan(filepath=str(tile))
    options = {"ensemble": "periodic", "replicas": (4, 3), "level": "none"}
    assert bpy.ops.diffraction.bake(**options) == {"FINISHED"}
    bake_file(tile, tmp_path / "python", BakeParameters(**options))
    for name in ("tile.exr", "tile.json"):
        assert (folder / "diffraction" / name).read_bytes() == (tmp_path / "python" / name).read_bytes()
    table = SpectralTable.load(folder / "diffraction" / "tile.exr")
    assert table.info["source"]["size_m"] == pytest.approx([4e-6, 3e-6])
    bpy.ops.mesh.primitive_plane_add()
    assert bpy.ops.diffraction.apply_material() == {"FINISHED"}
    assert bpy.context.object.active_material is not None
