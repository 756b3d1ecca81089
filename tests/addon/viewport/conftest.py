# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender with the add-on and a GPU context, in background mode."""

import pytest

from tests.support.blender import extension, scenes, tables
from tests.support.blender import viewport_scene as scene


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


@pytest.fixture
def sphere(renderer, tmp_path):
    """A diffracting sphere under one sun, seen by a camera."""
    tables.make_table(tmp_path / "table.exr", tables.lobes)
    ob = scenes.add_sphere(segments=64, rings=32)
    scenes.add_sun((0.3, 0.2, 1), strength=2)
    scenes.add_camera()
    scene.give_material(ob, tmp_path / "table.exr", fresnel="NONE")
    return ob


@pytest.fixture
def plane(renderer, tmp_path):
    """A diffracting plane of 2 x 2 m under a sun, seen from above; its material."""
    tables.make_table(tmp_path / "t.exr", tables.lobes)
    ob = scenes.add_plane(half=1.0)
    scenes.add_sun((0.3, 0.2, 1.0), strength=2.0)
    scenes.add_camera((0.1, 0.2, 1.0), extent=2.0)
    return scene.give_material(ob, tmp_path / "t.exr", fresnel="NONE")
