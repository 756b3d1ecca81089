# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the viewport without a window."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ...precompute.errors import OutputError, ParameterError
from ...precompute.files.atomic import atomic_path
from ..gpu_context import NoGpu, ensure_gpu
from . import gathering, surroundings
from .drawing import SKY_POINTS, Renderer
from .looks import View
from .manners import Manners, clip_planes

#: File formats by suffix: name and bits a channel.
FORMATS = {".png": ("PNG", "8"), ".jpg": ("JPEG", "8"), ".jpeg": ("JPEG", "8"), ".exr": ("OPEN_EXR", "32")}


@contextmanager
def view_3d() -> Iterator[dict]:
    """Window, area, region and space of the 3-D view that asks, or of another one.

    Where no window shows one, the largest area lends itself.

    Raises
    ------
    NoGpu
        If this Blender has no window, which a file saved with its interface brings.
    """
    here = bpy.context.area
    if here is not None and here.type == "VIEW_3D" and bpy.context.window is not None:
        region = next(r for r in here.regions if r.type == "WINDOW")
        space = here.spaces.active
        data = bpy.context.region_data or space.region_3d  # of the quarter that was asked, in quad view
        yield {"window": bpy.context.window, "area": here, "region": region, "space_data": space, "region_data": data}
        return
    windows = [w for manager in bpy.data.window_managers for w in manager.windows]
    areas = [(w, a) for w in windows for a in w.screen.areas]
    if not areas:
        raise NoGpu("This file has no window layout, so there is no 3-D view to draw; save it with its interface.")
    window, area = next(((w, a) for w, a in areas if a.type == "VIEW_3D"), (None, None))
    lent = None
    if area is None:
        window, area = max(areas, key=lambda pair: pair[1].width * pair[1].height)
        lent, area.type = area.type, "VIEW_3D"
    try:
        region = next(r for r in area.regions if r.type == "WINDOW")
        space = area.spaces.active
        yield {"window": window, "area": area, "region": region, "space_data": space, "region_data": space.region_3d}
    finally:
        if lent is not None:
            area.type = lent


def view_size(whole: tuple[int, int]) -> tuple[int, int]:
    """Width and height of a picture of the 3-D view: its own, or that of a render where it looks through a camera."""
    with view_3d() as override:
        if override["region_data"].view_perspective == "CAMERA":
            return whole
        return max(1, override["region"].width), max(1, override["region"].height)


@contextmanager
def _look(space: bpy.types.SpaceView3D, shading: str, depth_only: bool = False) -> Iterator[None]:
    """Lend a view its shading: a picture for the public, no overlays; for depth alone the cheapest."""
    wanted = [
        (space.shading, "type", shading),
        (space.overlay, "show_overlays", False),
        (space, "show_gizmo", False),
    ]
    preferences = bpy.context.preferences
    if depth_only:
        wanted += [
            (space.shading, "light", "FLAT"),
            (space.shading, "show_xray", False),
            (space.shading, "show_cavity", False),
            (space.shading, "show_shadows", False),
            (space.shading, "use_dof", False),
            (preferences, "is_dirty", preferences.is_dirty),
            (preferences.system, "viewport_aa", "OFF"),
        ]
    before = []
    try:
        for owner, name, value in wanted:
            before.append((owner, name, getattr(owner, name)))
            setattr(owner, name, value)
        yield
    finally:
        for owner, name, value in reversed(before):
            setattr(owner, name, value)


def render(
    renderer: Renderer,
    scene: bpy.types.Scene,
    camera: bpy.types.Object | None,
    size: tuple[int, int],
    shading: str,
    view: View,
    background: bool = True,
    samples: int = 1,
) -> np.ndarray:
    """The scene as its camera sees it, with diffraction.

    Parameters
    ----------
    camera
        None takes what the 3-D view shows.
    size
        Width and height in pixels.
    shading
        ``SOLID``, ``MATERIAL`` or ``RENDERED``: what is drawn under the diffraction.
    view
        The user's choice.
    background
        Draw the world or the view's background; else transparent.
    samples
        Points of each pixel at which the diffraction is evaluated, drawn from the renderer's pixel filter;
        one stands in its middle.

    Returns
    -------
    ndarray
        ``(height, width, 4)`` float32 scene-linear, row 0 at the bottom.

    Raises
    ------
    DiffractionError
        If there is no GPU or the drawing failed.
    """
    ensure_gpu()
    import gpu

    width, height = size
    with view_3d() as override, bpy.context.temp_override(**override, scene=scene):
        layer = scene.view_layers[0] if scene != bpy.context.scene else bpy.context.view_layer
        depsgraph = bpy.context.evaluated_depsgraph_get()
        space, region_data = override["space_data"], override["region_data"]
        if camera is None and region_data.view_perspective == "CAMERA":
            camera = space.camera
        if camera is not None:
            eye = camera.evaluated_get(depsgraph)
            view_matrix = np.array(eye.matrix_world.normalized().inverted())
            projection = np.array(camera.calc_matrix_camera(depsgraph, x=width, y=height))
        else:
            view_matrix, projection = np.array(region_data.view_matrix), np.array(region_data.window_matrix)
            region = override["region"]
            projection[0] *= (region.width / max(region.height, 1)) / (width / height)
        asks = Manners(clip=clip_planes(region_data))
        try:
            target = gpu.types.GPUOffScreen(width, height, format="RGBA32F")
        except Exception as error:
            raise ParameterError(f"The GPU has no room for {width} x {height} pixels; ask for fewer.") from error

        def draw_scene(matrix: np.ndarray) -> None:
            target.draw_view3d(
                scene, layer, space, override["region"], Matrix(view_matrix), Matrix(matrix),
                do_color_management=False, draw_background=background,
            )  # fmt: skip

        light = np.zeros((height, width, 4), np.float32)
        moves = gathering.moves(samples, SKY_POINTS[view.points])
        try:
            with _look(space, shading):
                around = surroundings.of_shading(scene, space.shading)
                draw_scene(projection)
                below = read(target)
            # EEVEE leaves no depth behind, and Workbench one that is not moved within the pixels.
            with _look(space, "SOLID", depth_only=True):
                for index, offset in enumerate(pixel_offsets(samples, filter_width(scene))):
                    moved = projection.copy()
                    moved[:2] -= np.outer(2.0 * offset / (width, height), projection[3])
                    draw_scene(moved)
                    with target.bind():
                        gpu.state.active_framebuffer_get().clear(color=(0.0, 0.0, 0.0, 0.0))
                        renderer.draw(
                            depsgraph, view_matrix, moved, view,
                            through_display=False,
                            visible=lambda ob: ob.visible_in_viewport_get(space),
                            list_key=1,
                            asks=asks,
                            around=around,
                            # The drawings share the sphere out: together they look in more directions.
                            moved=moves[index],
                            together=samples,
                            skips_nodes=shading != "SOLID",
                        )  # fmt: skip
                    if renderer.message:
                        raise ParameterError(renderer.message)
                    light += read(target) / samples
        finally:
            target.free()
    # Where surfaces are replaced their alpha is 1, where light is added it is 0.
    return below * (1.0 - light[..., 3:]) + light


def filter_width(scene: bpy.types.Scene) -> float:
    """Pixels over which a render's pixel filter reaches: Blender's Blackman-Harris spans twice its setting."""
    cycles = getattr(scene, "cycles", None)
    return 2.0 * (cycles.filter_width if cycles is not None else scene.render.filter_size)


def pixel_offsets(count: int, width: float) -> np.ndarray:
    """``(count, 2)`` offsets in pixels, distributed as the Blackman-Harris filter of a width is (Harris, 1978)."""
    if count == 1:
        return np.zeros((1, 2))
    x = np.linspace(0.0, 1.0, 1025)
    turn = 2.0 * np.pi * x
    density = 0.35875 - 0.48829 * np.cos(turn) + 0.14128 * np.cos(2 * turn) - 0.01168 * np.cos(3 * turn)
    share = np.cumsum(density) - 0.5 * density
    share = (share - share[0]) / (share[-1] - share[0])
    # An additive recurrence with the plastic number: even in both coordinates for any count.
    places = (0.5 + np.outer(np.arange(count), (0.7548776662466927, 0.5698402909980532))) % 1.0
    return (np.interp(places, share, x) - 0.5) * width


def read(target: Any) -> np.ndarray:
    """``(height, width, 4)`` float32 of an offscreen, row 0 at the bottom."""
    pixels = target.texture_color.read()
    pixels.dimensions = target.width * target.height * 4
    return np.array(pixels, np.float32).reshape(target.height, target.width, 4)


def save(pixels: np.ndarray, scene: bpy.types.Scene, path: Path, transparent: bool = False) -> None:
    """Write a picture as a render of the scene would be written; ``.exr`` keeps the scene-linear values.

    Raises
    ------
    OutputError
        If the suffix is unknown or the folder cannot be written.
    """
    from .data.display import write_as_render

    if path.suffix.lower() not in FORMATS:
        raise OutputError(f"'{path.name}' has no known picture format; use one of {', '.join(FORMATS)}.")
    file_format, depth = FORMATS[path.suffix.lower()]
    with atomic_path(path) as temporary:
        write_as_render(pixels, scene, temporary, file_format, depth, transparent)
