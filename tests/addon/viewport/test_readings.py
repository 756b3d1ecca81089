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
