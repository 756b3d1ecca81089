# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender with the add-on registered."""

import pytest

from tests.support.blender import extension


@pytest.fixture(scope="session")
def snake(tmp_path_factory):
    """A small table of the snake preset, and its path.

    Orders hundredths of a radian wide, speckle of a random surface, a peak a hundredth of a radian wide and a thousand
    times as bright as its surroundings.
    """
    from precompute.bake.baking import bake
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    table = bake(make_preset("snake", 40e-6, 640), BakeParameters(sigma_s_m=3e-6, level="poly2", detail=0.7))
    path = tmp_path_factory.mktemp("snake") / "snake.exr"
    table.save(path)
    return table, path


@pytest.fixture
def blender(empty_blender):
    """`bpy` with an empty scene that Cycles renders, the add-on registered."""
    package = extension.load()
    package.register()
    scene = empty_blender.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.shading_system = True
    yield empty_blender
    package.unregister()
