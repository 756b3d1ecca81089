# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3-D view asks of whoever draws in it: where not to draw, how faintly, and which objects the user works on."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Matrix, Vector

#: Modes in which the view shows the object's own work (the cage, weights) and any shading would hide it.
_ALWAYS_AWAY = {"EDIT", "WEIGHT_PAINT"}

#: Modes whose work lies in Solid view where the shading would be; in the others Blender shows the material, as we do.
_AWAY_IN_SOLID = {"SCULPT", "VERTEX_PAINT", "TEXTURE_PAINT"}


@dataclass(frozen=True)
class Manners:
    """How to draw in a view.

    Parameters
    ----------
    clip
        Planes (a, b, c, d) in world space: only what has a x + b y + c z + d > 0 for all of them is shown.
    border
        Left, bottom, right and top in pixels of the framebuffer, outside of which nothing is drawn.
    see_through
        Opacity of surfaces, below 1 in X-ray.
    """

    clip: tuple[tuple[float, float, float, float], ...] = ()
    border: tuple[float, float, float, float] | None = None
    see_through: float = 1.0


#: Of a picture of a camera.
PLAIN = Manners()


def of_view(
    context: bpy.types.Context, space: bpy.types.SpaceView3D, region: bpy.types.RegionView3D | None, eevee: bool
) -> Manners:
    """What the view that is being drawn asks.

    Parameters
    ----------
    eevee
        Whether EEVEE shades it, which draws inside of a render border only.
    """
    xray = space.shading.type == "SOLID" and space.shading.show_xray
    return Manners(
        clip=clip_planes(region),
        border=_border(context, space, region) if eevee and region is not None else None,
        see_through=space.shading.xray_alpha if xray else 1.0,
    )


def clip_planes(region: bpy.types.RegionView3D | None) -> tuple[tuple[float, float, float, float], ...]:
    """Planes of the clipping region (Alt+B), none where it is off."""
    if region is None or not region.use_clip_planes:
        return ()
    planes = [tuple(float(x) for x in plane) for plane in region.clip_planes]
    # A box seen from the side has four; the rest hold nothing.
    return tuple((a, b, c, d) for a, b, c, d in planes if (a, b, c) != (0.0, 0.0, 0.0))


def away(ob: bpy.types.Object, eevee: bool) -> bool:
    """Whether the user works on an original object in a way that our shading would hide."""
    return ob.mode in _ALWAYS_AWAY or (not eevee and ob.mode in _AWAY_IN_SOLID)


def modes(context: bpy.types.Context) -> tuple:
    """Which objects are in which mode: tells lists of what is drawn apart."""
    return tuple((ob.session_uid, ob.mode) for ob in getattr(context, "objects_in_mode", ()) if ob.mode != "OBJECT")


def _border(
    context: bpy.types.Context, space: bpy.types.SpaceView3D, region: bpy.types.RegionView3D
) -> tuple[float, float, float, float] | None:
    import gpu

    x, y, width, height = gpu.state.viewport_get()
    if region.view_perspective == "CAMERA" and space.camera is not None and space.camera.type == "CAMERA":
        render = context.scene.render
        if not render.use_border:
            return None
        frame = camera_frame(space.camera, context.scene, region.perspective_matrix)
        fractions = render.border_min_x, render.border_min_y, render.border_max_x, render.border_max_y
    elif space.use_render_border:
        frame = (0.0, 0.0, 1.0, 1.0)
        fractions = (
            space.render_border_min_x,
            space.render_border_min_y,
            space.render_border_max_x,
            space.render_border_max_y,
        )
    else:
        return None
    left, bottom, right, top = frame
    across, up = right - left, top - bottom
    return (
        x + width * (left + across * fractions[0]),
        y + height * (bottom + up * fractions[1]),
        x + width * (left + across * fractions[2]),
        y + height * (bottom + up * fractions[3]),
    )


def camera_frame(
    camera: bpy.types.Object, scene: bpy.types.Scene, to_clip: Matrix
) -> tuple[float, float, float, float]:
    """Left, bottom, right and top of what the camera takes in, as fractions of the view that shows it."""
    world = camera.matrix_world.normalized()
    corners = [to_clip @ (world @ corner).to_4d() for corner in camera.data.view_frame(scene=scene)]
    places = np.array([Vector(c).xy / c.w for c in corners])
    (left, bottom), (right, top) = 0.5 + 0.5 * places.min(0), 0.5 + 0.5 * places.max(0)
    return float(left), float(bottom), float(right), float(top)
