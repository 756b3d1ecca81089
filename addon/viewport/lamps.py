# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps as the viewport's shader takes them: radiant quantities as Cycles derives them from the light data."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

from ..lights import emitters
from ..lights import lamps as lights
from ..materials.osl import LAMP_KINDS, LAMPS_MAX
from .data.sky import Sky
from .items import MadeLamp

#: Directions (in the view's axes) and strengths of the lamps that stand in where a scene has none.
_STUDIO = (((-0.4, 0.5, 0.75), 3.0), ((0.8, 0.25, 0.55), 1.5), ((0.1, -0.7, 0.7), 0.8))


def scene_rows(
    depsgraph: bpy.types.Depsgraph,
    visible: Callable[[bpy.types.Object], bool],
    made: Sequence[MadeLamp] = (),
    middle: Vector | None = None,
) -> np.ndarray:
    """``(n, 6, 4)`` rows of the scene's lamps, at most ``LAMPS_MAX``: the same as the scene's list has.

    Parameters
    ----------
    depsgraph
        Evaluated.
    visible
        Whether an original object (of a lamp in a collection that an empty shows: the empty) is to be drawn.
    made
        Lamps that the depsgraph made.
    middle
        Where what is lit stands: of too many lamps those stay that shine brightest there.
    """
    found = [rows for rows in _all_rows(depsgraph, visible, made) if rows is not None]
    if len(found) > LAMPS_MAX:
        at = np.array(middle if middle is not None else (0.0, 0.0, 0.0))
        found.sort(key=lambda rows: -_irradiance(rows, at))
    return np.array(found[:LAMPS_MAX], np.float32).reshape(-1, 6, 4)


def _all_rows(
    depsgraph: bpy.types.Depsgraph, visible: Callable[[bpy.types.Object], bool], made: Sequence[MadeLamp]
) -> Iterator[np.ndarray | None]:
    scene = depsgraph.scene.original
    for lamp in lights.lamp_objects(scene):
        if visible(lamp.instancer if isinstance(lamp, lights.InstancedLamp) else lamp):
            yield lamp_rows(lamp.evaluated_get(depsgraph))
    yield from map(lamp_rows, made)
    for ob, colour in emitters.glowing(scene):
        if visible(ob):
            yield _glow_rows(ob.evaluated_get(depsgraph), colour)


def _irradiance(rows: np.ndarray, at: np.ndarray) -> float:
    """About what a lamp sheds on a place; shadows, cones and angles left out."""
    power = float(rows[4, :3].mean())
    if rows[0, 3] == LAMP_KINDS["SUN"]:
        return power
    if rows[0, 3] != LAMP_KINDS["BALL"]:
        power *= float(rows[3, 3])
    return power / max(float(((rows[0, :3] - at) ** 2).sum()), 1e-6)


def _glow_rows(ob: bpy.types.Object, colour: tuple[float, float, float]) -> np.ndarray:
    """Rows of a ball in place of a mesh that glows: it sheds as much as the mesh does on average over all sides."""
    middle, radius = emitters.ball(ob)
    world = ob.matrix_world
    place: Any = world @ middle
    rows = np.zeros((6, 4))
    rows[0] = *place, LAMP_KINDS["BALL"]
    rows[4, :3] = np.array(colour) * emitters.shadow_area(ob)
    rows[4, 3] = radius * max(world.to_scale())
    return rows


def sun_rows(suns: np.ndarray, sky: Sky) -> np.ndarray:
    """``(n, 6, 4)`` rows of what stands out of a sky.

    Parameters
    ----------
    suns
        ``(n, 7)``, see `data.sky.Lit`.
    sky
        Whose turn and strength they get.
    """
    rows = np.zeros((len(suns), 6, 4), np.float32)
    rows[:, 0, :3] = suns[:, :3] @ np.reshape(sky.turn, (3, 3))  # back from the image's directions
    rows[:, 0, 3] = LAMP_KINDS["SUN"]
    rows[:, 4, :3] = suns[:, 3:6] * np.array(sky.strength)
    rows[:, 4, 3] = suns[:, 6]
    rows[:, 5, 0] = 2.0 * np.sin(0.5 * suns[:, 6]) ** 2
    return rows


def lamp_rows(ob: lights.LampObject | MadeLamp) -> np.ndarray | None:
    """``(6, 4)`` rows of an evaluated lamp: place + kind, two half axes, normal, colour + size, extra; None if dark.

    With P the power in watts: a ball has the intensity P / 4 pi, an area lamp of area A the radiance P / (pi A),
    a sun the irradiance of its strength. Without "normalize" the radiance is P / pi whatever the size. Light
    nodes are not evaluated.
    """
    described: Any = ob  # what the depsgraph made is used like an object
    lamp, light = lights.describe(described), ob.data
    power = np.array(lamp.colour) * lamp.energy
    normalised = getattr(light, "normalize", True)
    if not power.any():
        return None
    rows = np.zeros((6, 4))
    rows[0] = *lamp.place, LAMP_KINDS[lamp.kind]
    rows[3, :3] = lamp.direction
    if lamp.kind == "SUN":
        rows[0, :3] /= np.linalg.norm(rows[0, :3])
        radius = 0.5 * lamp.size[0]
        if not normalised and radius > 0.0:
            power = power * (math.pi * math.sin(radius) ** 2)
        rows[4] = *power, radius
        rows[5, 0] = 2.0 * math.sin(0.5 * radius) ** 2  # 1 - cosine
    elif lamp.kind == "BALL":
        radius = lamp.size[0]
        intensity = power / (4.0 * math.pi)
        if not normalised:
            intensity = power / math.pi * (math.pi * radius**2 if radius > 0.0 else 1.0)
        rows[4] = *intensity, radius
        rows[5, 2] = float(getattr(light, "use_soft_falloff", True))
        if lamp.type == "SPOT":
            rows[1:4, :3] = np.array([axis / max(axis.length_squared, 1e-18) for axis in _axes(ob)])
            rows[3, :3] *= -1.0  # it shines along its -z
            cosine = math.cos(0.5 * lamp.spot_angle)
            rows[5, :2] = cosine, 1.0 / max((1.0 - cosine) * lamp.spot_blend, 1e-6)
            rows[1, 3] = 1.0
    else:
        half_u = 0.5 * lamp.size[0] * np.array(lamp.axis_u)
        half_v = 0.5 * lamp.size[1] * np.array(lamp.axis_v)
        area = np.linalg.norm(np.cross(half_u, half_v)) * (math.pi if lamp.kind == "ELLIPSE" else 4.0)
        rows[1, :3], rows[2, :3] = half_u, half_v
        rows[4, :3] = power / math.pi
        # colour x normal.w is the radiance times the area.
        rows[3, 3] = 1.0 if normalised else area
        half_spread = 0.5 * light.spread
        if half_spread < 0.5 * math.pi - 1e-4:
            rows[5, :2] = math.tan(half_spread), 1.0 / (math.tan(half_spread) - half_spread)
    return rows


def _axes(ob: lights.LampObject | MadeLamp) -> list[Vector]:
    """Axes of an object in world space, as long as it is scaled."""
    return [ob.matrix_world.col[i].xyz for i in range(3)]


def studio_rows(view: np.ndarray) -> np.ndarray:
    """``(3, 6, 4)`` rows of three soft suns that stand still with regard to the viewer.

    Parameters
    ----------
    view
        ``(4, 4)`` view matrix.
    """
    to_world = np.linalg.inv(np.asarray(view, float))[:3, :3]
    rows = np.zeros((len(_STUDIO), 6, 4), np.float32)
    for row, (direction, strength) in zip(rows, _STUDIO, strict=True):
        world = to_world @ np.array(direction)
        row[0] = *(world / np.linalg.norm(world)), LAMP_KINDS["SUN"]
        row[4] = strength, strength, strength, 0.02
        row[5, 0] = 2.0 * math.sin(0.5 * row[4, 3]) ** 2
    return rows
