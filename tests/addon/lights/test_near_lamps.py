# SPDX-License-Identifier: GPL-3.0-or-later
"""Area lamps as wide as they are far away, alone and under a sky, against numpy's sum over them."""

import bpy
import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import materials, scenes, tables, worlds
from tests.support.blender.lamps import add_lamp
from tests.truth import lamps as truth
from tests.truth import radiance
from tests.truth.hemisphere import hemisphere

BOTH = pytest.mark.parametrize("implementation", ["OSL", "NODES"])

VIEW = np.array([0.0, -0.5, 0.75**0.5])

#: Radiance of the lamps, that of the sky being 1.
RADIANCE = 100.0

#: By name: place, shape, sides; lamps face the origin.
NEAR = {
    "square overhead": ((0.0, 0.0, 1.0), "SQUARE", (2.0, 2.0)),
    "square aslant": ((0.5, 0.2, 0.8), "SQUARE", (1.2, 1.2)),
    "disc": ((0.3, 0.4, 0.8), "DISK", (1.4, 1.4)),
    "long strip": ((-0.3, 0.5, 0.8), "RECTANGLE", (0.25, 1.8)),
}


def near(name):
    """The lamp in the scene, and directions and irradiances of it at the origin."""
    place, shape, sides = NEAR[name]
    is_round = shape == "DISK"
    power = RADIANCE * np.pi * sides[0] * sides[1] * (np.pi / 4 if is_round else 1.0)
    more = {"size_y": sides[1]} if shape == "RECTANGLE" else {}
    lamp = add_lamp("AREA", place, shape=shape, size=sides[0], energy=power, **more)
    bpy.context.view_layer.update()
    axes = np.array(lamp.matrix_world)[:3, :3]
    u, v = (side * axes[:, number] for number, side in enumerate(sides))
    return truth.area(np.zeros(3), place, u, v, -axes[:, 2], power, is_round, nodes=48)


def f_cos(table, wi):
    """RGB for light from directions."""
    return radiance.gamut_step(radiance.f_cos_xyz(table, wi, VIEW, conserve=False), xyz_to_rgb_matrix())


@BOTH
@pytest.mark.parametrize("sky", [0.0, 1.0])
@pytest.mark.parametrize("name", NEAR)
def test_near_lamp(blender, tmp_path, implementation, name, sky):
    """Nodes took a lamp's radius for that of the ball about it, and its solid angle as a small one's."""
    table = tables.make_table(tmp_path / "t.exr", tables.gentle)
    plane = scenes.add_plane(half=0.005)
    scenes.add_camera(tuple(VIEW), extent=0.005)
    directions, irradiance = near(name)
    if sky:
        worlds.white_world()
    materials.diffracting(
        plane, tmp_path / "t.exr", implementation, fresnel="NONE", environment=int(sky), conserve_energy=False
    )
    bpy.context.scene.cycles.max_bounces = 1
    found = scenes.render(24, 196).mean((0, 1))
    by_lamp = (f_cos(table, directions) * irradiance[:, None]).sum(0)
    wi, solid = hemisphere(800)
    by_sky = (f_cos(table, wi) * solid[..., None]).sum((0, 1))
    expected = by_lamp + sky * by_sky
    # Lamps hide nothing behind them. The cone that holds a lamp has corners, which meet sky.
    assert np.all(found > 0.985 * expected)
    assert np.all(found < (1.03 if sky else 1.015) * expected)
