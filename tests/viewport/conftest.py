# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender with the add-on and a GPU context, in background mode."""

import pytest

from tests.addon import extension


@pytest.fixture
def blender(empty_blender):
    """`bpy` with an empty scene, the add-on registered and a context to draw in."""
    package = extension.load()
    package.register()
    import diffraction_shader.addon.viewport.offscreen as offscreen

    try:
        offscreen.ensure_gpu()
    except offscreen.NoGpu as error:
        package.unregister()
        pytest.skip(f"no OpenGL on this machine: {error}")
    yield empty_blender
    package.unregister()


@pytest.fixture
def renderer(blender):
    """What the viewport keeps between two drawings."""
    from diffraction_shader.addon.viewport import handlers

    handlers.renderer.clear()
    return handlers.renderer
