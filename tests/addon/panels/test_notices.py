# SPDX-License-Identifier: GPL-3.0-or-later
"""What is said without being asked: in the panel where there is a window, on the console where there is none."""

from dataclasses import replace
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from tests.support.blender import tables
from tests.support.blender.panels import plane_with_material, shown, words


@pytest.fixture
def windowed(blender, monkeypatch):
    """The module as in a Blender with a window."""
    from diffraction_shader.addon import notices

    notices.clear()
    monkeypatch.setattr(notices, "bpy", SimpleNamespace(app=SimpleNamespace(background=False)))
    yield notices
    notices.clear()


def test_without_a_window_on_the_console(blender, capsys):
    from diffraction_shader.addon import notices

    notices.say("Something happened")
    assert capsys.readouterr().out == "Diffraction: Something happened.\n"
    assert notices.said() == ()


def test_with_a_window_in_the_panel_till_another_file(windowed, capsys):
    windowed.say("Something happened")
    windowed.say("Something happened")
    assert capsys.readouterr().out == ""
    assert words(shown("main")).count("Something happened") == 1
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert windowed.said() == ()


def test_a_lost_table_is_told_as_long_as_it_is_lost(blender, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "scene.blend"))
    place = tmp_path / "diffraction" / "lost.exr"
    tables.make_table(place, tables.lobes)
    bpy.context.scene.diffraction.table_path = "//diffraction/lost.exr"
    plane_with_material()
    assert "bakes or finds it" not in words(shown("main"))
    place.rename(tmp_path / "kept.exr")
    assert "lost.exr is not in" in words(shown("main")) and "bakes or finds it" in words(shown("main"))
    (tmp_path / "kept.exr").rename(place)
    assert "bakes or finds it" not in words(shown("main"))


def test_small_sizes_are_not_nothing(blender):
    from diffraction_shader.addon.panels.sidebar import megabytes

    assert [megabytes(n) for n in (4e3, 9.6e5, 1.2e7, 2.5e9)] == ["4 kB", "960 kB", "12 MB", "2.50 GB"]


def test_the_levellings_picture_for_a_panel_is_square_and_tells_before_from_after(blender):
    from diffraction_shader.precompute.presets import make_preset
    from diffraction_shader.precompute.scan.levelling import level
    from diffraction_shader.precompute.scan.levelling_picture import levelling_thumbnail

    scan = make_preset("sinusoid", 8e-6, 64)
    tilted = replace(scan, heights=scan.heights + np.linspace(0.0, 5e-7, 64)[:, None])
    picture = levelling_thumbnail(tilted, level(tilted, "plane"), side=240)
    assert picture.shape == (240, 240, 3)
    before, after = picture[130:200, 20:90], picture[130:200, 140:210]
    # The slope before goes from bottom to top; what is left after levelling does not.
    assert abs(before[:10].mean() - before[-10:].mean()) > 3.0 * abs(after[:10].mean() - after[-10:].mean())
