# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawings without a window: the handler alone on black, or over what Blender draws."""

import bpy
import numpy as np


def eye(size):
    """View and projection matrix of the scene's camera for a square picture."""
    bpy.context.view_layer.update()
    camera = bpy.context.scene.camera
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return camera.matrix_world.normalized().inverted(), camera.calc_matrix_camera(depsgraph, x=size, y=size)


def alone(renderer, size=96, display=False, moved=(0.0, 0.0), together=1, asks=None, gathers=None, around=None, **view):
    """What the renderer draws on black without any depth: linear RGB (size, size, 3), row 0 at the bottom.

    With surroundings as Material Preview has them it draws what EEVEE does not show of materials made of nodes.
    """
    import gpu
    from diffraction_shader.addon.viewport import looks, manners, offscreen

    view_matrix, projection = eye(size)
    target = gpu.types.GPUOffScreen(size, size, format="RGBA32F")
    try:
        with target.bind():
            gpu.state.active_framebuffer_get().clear(color=(0, 0, 0, 0), depth=1.0)
            renderer.draw(
                bpy.context.evaluated_depsgraph_get(), np.array(view_matrix), np.array(projection),
                looks.View(**view), display, lambda ob: True, moved=moved, together=together, gathers=gathers,
                asks=manners.PLAIN if asks is None else asks, around=around, skips_nodes=around is not None,
            )  # fmt: skip
        assert not renderer.message, renderer.message
        return offscreen.read(target)[..., :3].astype(float)
    finally:
        target.free()


def mean_of_many(renderer, size, together=16, points=16):
    """`alone` as a picture is drawn: the mean of drawings that look in other directions."""
    from diffraction_shader.addon.viewport import gathering
    from diffraction_shader.addon.viewport.drawing import SKY_POINTS

    moves = gathering.moves(together, SKY_POINTS[points])
    return np.mean([alone(renderer, size, moved=each, together=together, points=points) for each in moves], 0)


def over_scene(renderer, size=96, shading="SOLID", **view):
    """The scene as its 3-D view draws it with the diffraction over it: scene-linear RGB, row 0 at the bottom."""
    from diffraction_shader.addon.viewport import looks, offscreen

    scene = bpy.context.scene
    return offscreen.render(renderer, scene, scene.camera, (size, size), shading, looks.View(**view))[..., :3]
