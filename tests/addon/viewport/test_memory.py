# SPDX-License-Identifier: GPL-3.0-or-later
"""Nothing piles up over a thousand drawings; the software renderer's textures and meshes count as process memory."""

import os
from pathlib import Path

import bpy
import numpy as np
import pytest
from mathutils import Matrix

from tests.support.blender import drawing, scenes, tables
from tests.support.blender import viewport_scene as scene


def resident():
    """Bytes of memory of this process."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="reads the memory of the process from /proc")
def test_a_thousand_drawings_of_a_changing_mesh(renderer, tmp_path):
    import gpu
    from diffraction_shader.addon.viewport import looks

    path = tmp_path / "table.exr"
    tables.make_table(path, tables.lobes, n_r=32, n_phi=40, n_w=4)
    sphere = scenes.add_sphere(segments=64, rings=32)
    sun = scenes.add_sun((0.3, 0.2, 1))
    scenes.add_camera()
    scene.give_material(sphere, path)
    target = gpu.types.GPUOffScreen(16, 16, format="RGBA32F")
    view, projection = (np.array(m) for m in drawing.eye(16))
    turn = Matrix.Rotation(0.1, 4, "Z")

    def draw(times):
        for index in range(times):
            sphere.data.transform(turn)
            sphere.data.update()
            sun.data.energy = 1.0 + index % 7
            if index % 50 == 0:  # a new bake now and then
                os.utime(path, (index, index))
            with target.bind():
                drawn = renderer.draw(
                    bpy.context.evaluated_depsgraph_get(), view, projection, looks.View(), False, lambda ob: True
                )
            assert drawn == 1 and not renderer.message
        return resident()

    draw(200)
    before = draw(100)
    after = draw(1000)
    # A mesh is 8192 corners of 40 bytes and its indices: a leak of one a drawing would be 350 MB.
    assert after - before < 20e6
    assert len(renderer.meshes) == len(renderer.tables) == 1
    assert len(renderer._uniforms) == 2


def test_what_is_not_drawn_is_freed(renderer, tmp_path):
    tables.make_table(tmp_path / "table.exr", tables.lobes, n_r=32, n_phi=40, n_w=4)
    spheres = [scenes.add_sphere(f"sphere {i}", segments=16, rings=8) for i in range(3)]
    scenes.add_sun((0.3, 0.2, 1))
    scenes.add_camera()
    for sphere in spheres:
        scene.give_material(sphere, tmp_path / "table.exr", name=sphere.name)
    drawing.alone(renderer, 16)
    assert (len(renderer.meshes), len(renderer.tables), len(renderer._uniforms)) == (3, 1, 4)
    for sphere in spheres[1:]:
        bpy.data.objects.remove(sphere)
    drawing.alone(renderer, 16)
    assert (len(renderer.meshes), len(renderer.tables), len(renderer._uniforms)) == (1, 1, 2)
    spheres[0].data.materials.clear()
    drawing.alone(renderer, 16)
    assert (len(renderer.meshes), len(renderer.tables), len(renderer._uniforms)) == (0, 0, 1)


def test_still_scene_uploads_nothing(renderer, tmp_path, monkeypatch):
    """A drawing with only another view of the same scene reads no mesh and no table again."""
    from diffraction_shader.addon.viewport.data import batches, textures

    tables.make_table(tmp_path / "table.exr", tables.lobes, n_r=32, n_phi=40, n_w=4)
    sphere = scenes.add_sphere(segments=16, rings=8)
    sun = scenes.add_sun((0.3, 0.2, 1))
    scenes.add_camera()
    scene.give_material(sphere, tmp_path / "table.exr")
    drawing.alone(renderer, 16)

    def never(*_):
        raise AssertionError("uploaded again")

    monkeypatch.setattr(batches, "_upload", never)
    monkeypatch.setattr(textures, "upload", never)
    bpy.context.scene.camera.location.x += 0.1
    sphere.location.y = 0.2
    sun.data.energy = 3.0
    assert drawing.alone(renderer, 16).any()
