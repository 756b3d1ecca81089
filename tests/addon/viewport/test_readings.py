# SPDX-License-Identifier: GPL-3.0-or-later
"""A drawing of the window waits for no file: threads read tables, and the view goes on without them till then."""

import threading
import time

import bpy
import numpy as np
import pytest

from tests.support.blender import drawing, tables


def read_by_now(renderer):
    """Waits for the threads; a window's timers would draw then."""
    from diffraction_shader.addon.viewport.data import readings

    for reading in (renderer.tables._texels, renderer.tables._tiles, renderer.directions._readings):
        assert isinstance(reading, readings.Readings)
        for thread in list(reading._threads.values()):
            thread.join(60.0)
        reading._threads.clear()


def test_a_window_draws_without_a_table_till_it_is_read(renderer, sphere):
    assert not drawing.alone(renderer, display=True).any()
    read_by_now(renderer)
    first = drawing.alone(renderer, display=True)
    assert first.any()
    renderer.clear()
    drawing.alone(renderer)  # as an operator does, which waits
    assert drawing.alone(renderer, display=True) == pytest.approx(first, abs=1e-3)


def test_albedos_of_a_scaled_surface_are_read_beside_the_window_too(renderer, sphere):
    node = sphere.data.materials[0].node_tree.nodes["Diffraction"]
    node.inputs["Scale"].default_value = 0.8
    bpy.context.view_layer.update()
    renderer.note()
    for _ in range(2):  # the table, then its tiles
        assert not drawing.alone(renderer, display=True).any()
        read_by_now(renderer)
    assert drawing.alone(renderer, display=True).any()
    assert drawing.alone(renderer).any()


def test_the_last_bake_is_shown_till_the_new_one_is_read(renderer, sphere, tmp_path):
    drawing.alone(renderer)
    first = drawing.alone(renderer, display=True)
    tables.make_table(tmp_path / "table.exr", lambda u, v, w: 3 * tables.lobes(u, v, w))
    assert drawing.alone(renderer, display=True) == pytest.approx(first, abs=1e-3)
    read_by_now(renderer)
    assert drawing.alone(renderer, display=True).sum() > 1.1 * first.sum()


#: Blender 4.5 cannot draw into a layer of a texture, so there a table arrives at once.
in_parts = pytest.mark.skipif(bpy.app.version < (5, 0), reason="this Blender copies tables to the GPU at once")


@in_parts
def test_a_large_table_is_copied_to_the_gpu_over_several_drawings(renderer, sphere, tmp_path, monkeypatch):
    """What was there before is shown till then, then the same picture as when it is copied at once."""
    from diffraction_shader.addon.viewport.data import textures

    whole = drawing.alone(renderer, display=True) if drawing.alone(renderer).any() else None
    renderer.clear()
    monkeypatch.setattr(textures, "AT_ONCE", 5.0 * 4 * 4 * 96 * 122)  # five of its twelve layers
    pictures = []
    drawing.alone(renderer, display=True)
    read_by_now(renderer)
    for _ in range(5):
        pictures.append(drawing.alone(renderer, display=True))
    assert [each.any() for each in pictures] == [False, False, False, True, True]
    np.testing.assert_array_equal(pictures[3], whole)
    tables.make_table(tmp_path / "table.exr", lambda u, v, w: 3 * tables.lobes(u, v, w))
    drawing.alone(renderer, display=True)
    read_by_now(renderer)
    np.testing.assert_array_equal(drawing.alone(renderer, display=True), whole)
    tables.make_table(tmp_path / "table.exr", lambda u, v, w: 0.5 * tables.lobes(u, v, w))
    for _ in range(2):  # another file on the way: the one before is given up
        np.testing.assert_array_equal(drawing.alone(renderer, display=True), whole)
        read_by_now(renderer)
    for _ in range(3):
        darker = drawing.alone(renderer, display=True)
    assert 0.0 < darker.sum() < 0.9 * whole.sum()
    np.testing.assert_array_equal(drawing.alone(renderer, display=True), darker)
    tables.make_table(tmp_path / "table.exr", tables.lobes)
    drawing.alone(renderer, display=True)
    read_by_now(renderer)
    drawing.alone(renderer, display=True)
    assert drawing.alone(renderer).sum() > 1.2 * darker.sum()  # an operator waits for what is on its way


@in_parts
def test_half_floats_arrive_on_the_gpu_as_they_are(renderer):
    import gpu
    from diffraction_shader.addon.viewport.copies import Copy

    layers = np.random.default_rng(3).random((3, 7, 5, 4), np.float32).astype(np.float16)
    layers[1, 2, 3] = 6e-8, 6.1e-5, 65504.0, -0.25  # the smallest there is, and the largest
    copy = Copy(layers.astype(np.float32))
    assert not copy.go_on(1.0) and copy.go_on(1e9)
    for index, expected in enumerate(layers.astype(np.float32)):
        target = gpu.types.GPUFrameBuffer(color_slots=({"texture": copy.texture, "layer": index},))
        with target.bind():
            found = np.array(target.read_color(0, 0, 5, 7, 4, 0, "FLOAT").to_list(), np.float32)
        np.testing.assert_array_equal(found, expected)


def test_a_table_that_went_missing_is_said_and_found_again(renderer, sphere, tmp_path, capsys):
    from diffraction_shader.addon.viewport import looks

    drawing.alone(renderer)
    kept = (tmp_path / "table.exr").read_bytes()
    (tmp_path / "table.exr").unlink()
    view, projection = drawing.eye(16)

    def draw():
        depsgraph = bpy.context.evaluated_depsgraph_get()
        renderer.draw(depsgraph, np.array(view), np.array(projection), looks.View(), True, lambda ob: True)
        read_by_now(renderer)

    for _ in range(4):
        draw()
        renderer.note()
    assert "table.exr" in renderer.message
    (tmp_path / "table.exr").write_bytes(kept)
    for _ in range(2):
        draw()
    assert not renderer.message and drawing.alone(renderer, display=True).any()


def test_one_thread_reads_a_file_once(blender, tmp_path):
    from diffraction_shader.addon.viewport.data.readings import Readings

    may_end, calls = threading.Event(), []

    def read(path):
        calls.append(path)
        may_end.wait(60.0)
        return len(calls)

    readings = Readings(read)
    path = tmp_path / "table.exr"
    assert readings.take(path, (1,), wait=False) is None
    assert readings.take(path, (1,), wait=False) is None
    may_end.set()
    deadline = time.monotonic() + 60.0
    while (found := readings.take(path, (1,), wait=False)) is None:
        assert time.monotonic() < deadline
    assert found == 1 and calls == [path]
    assert readings.take(path, (1,), wait=True) == 2
