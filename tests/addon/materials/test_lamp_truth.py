# SPDX-License-Identifier: GPL-3.0-or-later
"""Each type of lamp, small and wide, one and eight of them, on the snake table: against sums over the lamps."""

import math

import bpy
import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import materials, scenes
from tests.support.blender.lamps import add_lamp
from tests.truth import lamps as truth
from tests.truth import radiance

VIEW = np.array((0.35, 0.25, 0.9)) / np.linalg.norm((0.35, 0.25, 0.9))
SIZE, EXTENT = 12, 0.4

#: Kinds by name: type, properties, and how the truth sums over it.
KINDS = {
    "small sun": ("SUN", {"angle": 0.02, "energy": 3.0}),
    "wide sun": ("SUN", {"angle": 0.4, "energy": 3.0}),
    "small point": ("POINT", {"shadow_soft_size": 0.01, "energy": 200.0}),
    "wide point": ("POINT", {"shadow_soft_size": 0.3, "energy": 200.0}),
    "small spot": ("SPOT", {"shadow_soft_size": 0.01, "spot_size": 1.2, "spot_blend": 0.4, "energy": 200.0}),
    "wide spot": ("SPOT", {"shadow_soft_size": 0.2, "spot_size": 1.6, "spot_blend": 1.0, "energy": 200.0}),
    "small square": ("AREA", {"shape": "SQUARE", "size": 0.05}),
    "wide rectangle": ("AREA", {"shape": "RECTANGLE", "size": 1.0, "size_y": 0.4}),
    "wide disk": ("AREA", {"shape": "DISK", "size": 0.8}),
}


def place(number):
    """Places of eight lamps round the plane, none where the view's mirror image lies."""
    turn = math.radians(10 + 45 * number)
    away = 1.5 if math.cos(turn - math.radians(215)) < 0.5 else 2.4
    return (away * math.cos(turn), away * math.sin(turn), 1.6)


def fine_cone(axis, radius):
    """`truth._cone`, fine enough for a table whose lobes are hundredths of a radian wide."""
    fine = radius > 0.05
    return truth._cone(axis, np.cos(radius), rings=24 if fine else 4, spokes=72 if fine else 8)


def light_of(lamp, points):
    """Directions and irradiances of a lamp at points, whatever it is."""
    data, matrix = lamp.data, np.array(lamp.matrix_world)
    aim, where = -matrix[:3, 2], matrix[:3, 3]
    if data.type == "SUN":
        axis = np.broadcast_to(-aim, points.shape)
        directions, weights = fine_cone(axis, np.full(points.shape[:-1], data.angle / 2).max())
        return directions, weights * data.energy * _sun_gain(data.angle / 2)
    if data.type == "AREA":
        sides = data.size, data.size_y if data.shape == "RECTANGLE" else data.size
        nodes = 32 if max(sides) > 0.1 else 4
        u, v = (side * matrix[:3, axis] for axis, side in enumerate(sides))
        return truth.area(points, where, u, v, aim, data.energy, data.shape == "DISK", nodes)
    to = where - points
    distance = np.linalg.norm(to, axis=-1)
    radius = data.shadow_soft_size
    cos_radius = np.sqrt(1 - (radius / distance) ** 2)
    fine = radius > 0.05
    directions, weights = truth._cone(
        to / distance[..., None], cos_radius, rings=24 if fine else 4, spokes=72 if fine else 8
    )
    irradiance = weights * data.energy / (4 * np.pi**2 * radius**2) * 2 * np.pi * (1 - cos_radius)
    if data.type == "SPOT":
        cosine = -(to / distance[..., None] * aim).sum(-1)
        edge = np.clip(
            (cosine - np.cos(data.spot_size / 2)) / ((1 - np.cos(data.spot_size / 2)) * data.spot_blend), 0, 1
        )
        irradiance = irradiance * edge**2 * (3 - 2 * edge)
    return directions, irradiance


def _sun_gain(radius):
    """Even radiance over the disc whose projected area gives the strength."""
    return 2 * (1 - np.cos(radius)) / np.sin(radius) ** 2


def expected(table, camera_points, lamps):
    """RGB of the plane, each pixel."""
    total = np.zeros((*camera_points.shape[:-1], 3))
    for lamp in lamps:
        for wi, irradiance in zip(*light_of(lamp, camera_points), strict=True):
            f_cos = radiance.gamut_step(radiance.f_cos_xyz(table, wi, VIEW), xyz_to_rgb_matrix())
            total += f_cos * irradiance[..., None]
    return total


def picture_and_truth(table, count, name, samples):
    kind, data = KINDS[name]
    if kind in {"POINT", "SPOT"}:
        data = {
            **data,
            "use_soft_falloff": False,
        }  # a ball; else a disc, which is dimmer nearby
    lamps = [add_lamp(kind, place(3 * number + 1), name=f"{number}", **data) for number in range(count)]
    plane = scenes.add_plane()
    camera = scenes.add_camera(tuple(VIEW), extent=EXTENT)
    materials.diffracting(plane, table, fresnel="NONE", environment=0)
    image = scenes.render(SIZE, samples)
    origins, direction = scenes.camera_rays(2 * SIZE, camera)  # four points a pixel
    points = origins - (origins[..., 2:] / direction[2]) * direction
    return image, points, lamps


#: Wide ones of which the fast tier has another of the same sampling.
SLOW = {"wide point", "wide spot", "wide rectangle"}


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name in SLOW else ()) for name in KINDS])
def test_one_lamp(blender, snake, name):
    table, path = snake
    samples = 1024 if name.startswith("wide") else 128
    image, points, lamps = picture_and_truth(path, 1, name, samples)
    truth_image = expected(table, points, lamps)
    assert truth_image.mean() > 0.01
    assert image.mean() == pytest.approx(truth_image.mean(), rel=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_eight_lamps(blender, snake, name):
    table, path = snake
    image, points, lamps = picture_and_truth(path, 8, name, samples=4096)
    truth_image = expected(table, points, lamps)
    assert image.mean() == pytest.approx(truth_image.mean(), rel=0.01)
    assert image.mean((0, 1)) == pytest.approx(truth_image.mean((0, 1)), rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", KINDS)
def test_eight_lamps_on_constant_f(blender, monkeypatch, tmp_path, name):
    from tests.support.blender.against_diffuse import both

    kind, data = KINDS[name]
    for number in range(8):
        add_lamp(kind, place(number), name=f"{number}", **data)
    plane = scenes.add_plane()
    scenes.add_camera(tuple(VIEW), extent=EXTENT)
    ours, diffuse = both(plane, monkeypatch, tmp_path, samples=512)
    assert bpy.context.scene.cycles.samples == 512
    assert ours.mean() == pytest.approx(diffuse.mean(), rel=0.01)
