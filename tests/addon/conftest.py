# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender with the add-on registered."""

import pytest

from tests.addon import extension


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
