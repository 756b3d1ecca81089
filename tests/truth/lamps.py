# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of lamps at points by quadrature over the lamp, from what Blender's manual says of their power.

Every function returns directions ``(n, ..., 3)`` to points of the lamp, and the irradiance ``(n, ...)`` that each
brings to a surface that faces it, for points of shape ``(..., 3)``; the sum over n is the whole lamp.
"""

import numpy as np


def _unit(v):
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def _cone(axis, cos_radius, rings=12, spokes=24):
    """Directions within a cone about each axis, even in solid angle by Gauss's rule; weights sum to 1."""
    node, weight = np.polynomial.legendre.leggauss(rings)
    turn = (np.arange(spokes) + 0.5) * 2 * np.pi / spokes
    helper = np.where(np.abs(axis[..., :1]) < 0.5, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    e1 = _unit(np.cross(axis, helper))
    e2 = np.cross(axis, e1)
    directions, weights = [], []
    for x, w in zip(node, weight, strict=True):
        z = (1 + cos_radius) / 2 + (1 - cos_radius) / 2 * x
        s = np.sqrt(np.maximum(0, 1 - z * z))
        for a in turn:
            directions.append(z[..., None] * axis + (s * np.cos(a))[..., None] * e1 + (s * np.sin(a))[..., None] * e2)
            weights.append(np.full(z.shape, w / 2 / spokes))
    return np.array(directions), np.array(weights)


def sun(points, direction, strength, angle=0.0):
    """A disc in the sky, `angle` across; its strength is the irradiance on a surface that faces it."""
    axis = np.broadcast_to(_unit(np.asarray(direction, float)), points.shape)
    if angle == 0.0:
        return axis[None], np.full((1, *points.shape[:-1]), float(strength))
    cos_radius = np.full(points.shape[:-1], np.cos(angle / 2))
    directions, weights = _cone(axis, cos_radius)
    radiance = strength / (np.pi * np.sin(angle / 2) ** 2)
    return directions, weights * radiance * 2 * np.pi * (1 - cos_radius)


def ball(points, place, power, radius=0.0, aim=None, spot=None):
    """A sphere that radiates `power` evenly; `spot` = (full angle, blend) narrows it to a cone along `aim`."""
    to = np.asarray(place, float) - points
    distance = np.linalg.norm(to, axis=-1)
    axis = to / distance[..., None]
    if radius == 0.0:
        directions, irradiance = axis[None], (power / (4 * np.pi * distance**2))[None]
    else:
        cos_radius = np.sqrt(1 - (radius / distance) ** 2)
        directions, weights = _cone(axis, cos_radius)
        irradiance = weights * power / (4 * np.pi**2 * radius**2) * 2 * np.pi * (1 - cos_radius)
    if spot is not None:
        angle, blend = spot
        cosine = -(axis * _unit(np.asarray(aim, float))).sum(-1)
        edge = np.clip((cosine - np.cos(angle / 2)) / ((1 - np.cos(angle / 2)) * blend), 0, 1)
        irradiance = irradiance * edge**2 * (3 - 2 * edge)
    return directions, irradiance


def area(points, place, side_u, side_v, aim, power, ellipse=False, nodes=12):
    """A flat lamp with sides (axes, for an ellipse) `side_u` and `side_v` that shines along `aim`."""
    side_u, side_v, aim = (np.asarray(x, float) for x in (side_u, side_v, aim))
    node, weight = np.polynomial.legendre.leggauss(nodes)
    if ellipse:
        r = np.sqrt((node + 1) / 2)
        turn = (np.arange(2 * nodes) + 0.5) * np.pi / nodes
        places = [(a * np.cos(t), a * np.sin(t)) for a in r for t in turn]
        weights = np.repeat(weight / 2, 2 * nodes) / (2 * nodes)
        size = np.pi / 4 * np.linalg.norm(np.cross(side_u, side_v))
    else:
        places = [(a, b) for a in node for b in node]
        weights = np.array([a * b / 4 for a in weight for b in weight])
        size = np.linalg.norm(np.cross(side_u, side_v))
    radiance = power / (np.pi * size)
    directions, irradiance = [], []
    for (a, b), w in zip(places, weights, strict=True):
        to = np.asarray(place, float) + a * side_u / 2 + b * side_v / 2 - points
        distance2 = (to**2).sum(-1)
        direction = to / np.sqrt(distance2)[..., None]
        cosine = np.maximum(-(direction * _unit(aim)).sum(-1), 0)
        directions.append(direction)
        irradiance.append(radiance * size * w * cosine / distance2)
    return np.array(directions), np.array(irradiance)
