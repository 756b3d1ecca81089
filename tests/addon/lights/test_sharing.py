# SPDX-License-Identifier: GPL-3.0-or-later
"""N lamps count N times: lobes of lamps that stand close together, and of lamps that do not shine evenly."""

import math

import bpy
import pytest
from mathutils import Matrix, Vector

from tests.support.blender import materials, scenes
from tests.support.blender.against_diffuse import both

PLACE, WHITE, RED, BLUE = (1.0, 1.2, 1.6), (1, 1, 1), (1, 0.02, 0.02), (0.02, 0.02, 1)


@pytest.fixture(scope="module")
def blazed(tmp_path_factory):
    """A small table of a blazed grating: narrow orders, so that lamps side by side see different colours."""
    from precompute.bake.baking import bake
    from precompute.parameters import BakeParameters
    from precompute.presets import make_preset

    path = tmp_path_factory.mktemp("blazed") / "blazed.exr"
    bake(make_preset("blazed", 20e-6, 400), BakeParameters(sigma_s_m=2e-6, level="none", detail=0.5)).save(path)
    return path


def area(place, look, colour=WHITE, energy=50.0, **data):
    """An area lamp at a place that looks at another."""
    light = bpy.data.lights.new("lamp", "AREA")
    light.energy, light.color = energy, colour
    for key, value in data.items():
        setattr(light, key, value)
    ob = bpy.data.objects.new("lamp", light)
    ob.matrix_world = (
        Matrix.Translation(place) @ (Vector(look) - Vector(place)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    )
    bpy.context.scene.collection.objects.link(ob)
    return ob


def shot(samples, lamps):
    """Mean colour under lamps, which are gone afterwards."""
    found = scenes.render(24, samples).mean((0, 1))
    for lamp in lamps:
        bpy.data.objects.remove(lamp)
    return found


def strips(samples, *lamps):
    made = [area((1 + x, 1.2, 1.6), (x, 0, 0), colour, shape="RECTANGLE", size=0.2, size_y=2) for x, colour in lamps]
    return shot(samples, made)


def panel(count):
    """A square lamp of 2 m in tiles."""
    whole = Matrix.Translation(PLACE) @ (-Vector(PLACE)).to_track_quat("-Z", "Y").to_matrix().to_4x4()
    for i in range(count * count):
        tile = area(PLACE, (0, 0, 0), size=2 / count, energy=50 / count**2)
        matrix = whole.copy()
        matrix.translation = whole @ Vector(((i % count + 0.5) / count * 2 - 1, (i // count + 0.5) / count * 2 - 1, 0))
        tile.matrix_world = matrix
        yield tile


def on_plane(table):
    plane = scenes.add_plane(half=0.5)
    scenes.add_camera((0, -2, 2), extent=1.0)
    materials.diffracting(plane, table, fresnel="CONDUCTOR", environment=0)
    return plane


@pytest.mark.parametrize(
    "apart", [0.25, pytest.param(1.0, marks=pytest.mark.slow), pytest.param(2.0, marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("colours", [(WHITE, WHITE), (RED, BLUE)])
def test_two_strips_are_the_sum_of_each(blender, blazed, apart, colours):
    on_plane(blazed)
    first, second = (0, colours[0]), (apart, colours[1])
    assert strips(256, first, second) == pytest.approx(strips(256, first) + strips(256, second), rel=0.03)


@pytest.mark.slow
def test_panel_of_sixteen_is_the_sum_of_each(blender, blazed):
    on_plane(blazed)
    together = shot(512, list(panel(4)))
    assert together == pytest.approx(sum(shot(64, [tile]) for tile in panel_one_by_one(4)), rel=0.03)


def panel_one_by_one(count):
    """The tiles of `panel`, each alone."""
    for number in range(count * count):
        tiles = list(panel(count))
        for other in tiles[:number] + tiles[number + 1 :]:
            bpy.data.objects.remove(other)
        yield tiles[number]


@pytest.mark.parametrize("spread", [60, 20])
def test_spread_on_constant_f_equals_diffuse(blender, monkeypatch, tmp_path, spread):
    area(PLACE, (0, 0, 0), size=2, spread=math.radians(spread))
    plane = scenes.add_plane(half=0.5)
    scenes.add_camera((0, -2, 2), extent=1.0)
    ours, diffuse = both(plane, monkeypatch, tmp_path, samples=1024)
    assert diffuse.mean() > 0.01
    assert ours.mean() == pytest.approx(diffuse.mean(), rel=0.03)


def test_portal_gets_no_lobe(blender, blazed):
    on_plane(blazed)
    lamp = area(PLACE, (0, 0, 0), size=2)
    bpy.context.view_layer.update()
    assert bpy.context.scene["diffraction_lamps"] == 1
    lamp.data.cycles.is_portal = True
    lamp.data.energy = 51.0
    bpy.context.view_layer.update()
    assert bpy.context.scene["diffraction_lamps"] == 0
