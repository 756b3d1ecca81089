# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws when Blender draws, and takes note of what changed in between."""

from __future__ import annotations

import time
from dataclasses import replace

import bpy
import numpy as np
from bpy.app.handlers import persistent

from ..versions import EEVEE
from . import manners, settings, surroundings
from .data import sources
from .data.display import redraw
from .kept import renderer

_draw_handle = None


def draw_view() -> None:
    """The 3-D view's draw handler (POST_VIEW)."""
    import gpu

    context = bpy.context
    scene, space = context.scene, context.space_data
    if not scene.diffraction_viewport.show or space is None or not settings.shows(space):
        return
    shading = space.shading.type
    # Cycles shows the material itself.
    if shading == "WIREFRAME" or (shading == "RENDERED" and scene.render.engine == "CYCLES"):
        return
    eevee = shading == "MATERIAL" or (shading == "RENDERED" and scene.render.engine == EEVEE)
    around = surroundings.of_shading(scene, space.shading)
    asks = manners.of_view(context, space, context.region_data, eevee)
    view = scene.diffraction_viewport.view()
    region = context.region.as_pointer() if context.region is not None else 0
    if asks.see_through < 1.0:  # nothing is opaque there
        view = replace(view, surface="ADD")
    renderer.draw(
        context.evaluated_depsgraph_get(),
        np.array(gpu.matrix.get_model_view_matrix()),
        np.array(gpu.matrix.get_projection_matrix()),
        view,
        through_display=True,
        visible=lambda ob: ob.visible_in_viewport_get(space) and not manners.away(ob, eevee),
        list_key=(space.as_pointer() if space.local_view is not None else 0, eevee, *manners.modes(context)),
        skips_nodes=eevee,  # EEVEE shows what its lamps and the world send to them
        loose_depth=eevee,
        asks=asks,
        around=around,
        gathers=region,
    )
    if context.area is not None and renderer.gathering.wants_more(region):
        _again.ask(context.area, moved=not renderer.gathering.has_begun(region))


#: Seconds for which a view stands still before it is drawn again, and between two such drawings at least and at most.
_STILL, _LEAST, _MOST = 0.15, 0.01, 1.0


class _Again:
    """Draws views again that would gather more light, and leaves the user as much time as drawing takes."""

    def __init__(self) -> None:
        self._areas: set[int] = set()
        self._asked = self._not_before = 0.0

    def ask(self, area: bpy.types.Area, moved: bool) -> None:
        """Ask for another drawing of a view, soon.

        Parameters
        ----------
        moved
            Whether it did not stand still until now.
        """
        if bpy.app.background:
            return
        now = time.monotonic()
        wait = _STILL if moved else min(max(now - self._asked, _LEAST), _MOST)
        self._not_before = now + wait
        if not self._areas:
            bpy.app.timers.register(self._draw, first_interval=wait)
        self._areas.add(area.as_pointer())

    def _draw(self) -> float | None:
        now = time.monotonic()
        if now < self._not_before and self._areas:
            return self._not_before - now
        self._asked = now
        redraw(self._areas)
        self._areas = set()
        return None

    def clear(self) -> None:
        """Ask for nothing."""
        self._areas = set()


_again = _Again()


@persistent
def _updated(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph | None = None) -> None:
    changed = set()
    for update in depsgraph.updates if depsgraph is not None else ():
        if update.is_updated_geometry:
            changed.add(update.id.original.session_uid)
    renderer.note(changed)


@persistent
def _replaced(*_: object) -> None:
    """Undo or another file: nothing that was read before can be trusted."""
    renderer.note(None)


@persistent
def _before_load(*_: object) -> None:
    renderer.clear()


_HANDLERS = (
    (bpy.app.handlers.depsgraph_update_post, _updated),
    (bpy.app.handlers.frame_change_post, _updated),
    (bpy.app.handlers.undo_post, _replaced),
    (bpy.app.handlers.redo_post, _replaced),
    (bpy.app.handlers.load_pre, _before_load),
    (bpy.app.handlers.load_post, _replaced),
)


def register() -> None:
    """Begin to draw."""
    global _draw_handle
    for where, handler in _HANDLERS:
        where.append(handler)
    _draw_handle = bpy.types.SpaceView3D.draw_handler_add(draw_view, (), "WINDOW", "POST_VIEW")


def unregister() -> None:
    """Stop, and free all GPU memory."""
    global _draw_handle
    if _draw_handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_draw_handle, "WINDOW")
        _draw_handle = None
    for where, handler in _HANDLERS:
        if handler in where:
            where.remove(handler)
    _again.clear()
    renderer.clear()
    sources.free()
    redraw()
