# SPDX-License-Identifier: GPL-3.0-or-later
"""Energy: surfaces in a white furnace, as Cycles renders them."""

import bpy
import numpy as np
import pytest

from precompute.bake.baking import bake
from precompute.light.colour import luminance_row, xyz_to_rgb_matrix
from precompute.parameters import BakeParameters
from precompute.presets import PRESETS, make_preset
from precompute.table.table import SpectralTable
from tests.support.blender import materials, scenes
from tests.support.blender.worlds import white_world
from tests.truth import radiance
from tests.truth.hemisphere import hemisphere


def furnace(path, theta, samples=64, size=48, **settings):
    """RGB of a plane seen at an angle in a white world."""
    white_world()
    plane = scenes.add_plane(half=1.0)
    view = (0.6 * np.sin(np.radians(theta)), 0.8 * np.sin(np.radians(theta)), np.cos(np.radians(theta)))
    scenes.add_camera(view, extent=0.3)
    materials.diffracting(plane, path, fresnel="NONE", **settings)
    return scenes.render(size, samples), np.array(view)


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    path = tmp_path_factory.mktemp("flat") / "flat.exr"
    bake(make_preset("flat", 65e-6, 690), BakeParameters(sigma_s_m=6.5e-6)).save(path)
    return path


@pytest.mark.parametrize("theta", [0, 30, 60])
def test_flat_patch_reflects_everything(blender, flat, theta):
    image, _ = furnace(flat, theta)
    assert image.mean((0, 1)) == pytest.approx((1, 1, 1), abs=0.005)


@pytest.mark.parametrize("name", ["blazed", "sinusoid"])
@pytest.mark.parametrize("theta", [0, 50, 80])
def test_gratings_equal_the_quadrature_and_gain_nothing(blender, tmp_path, name, theta):
    table = bake(make_preset(name, 30e-6, 330), BakeParameters(sigma_s_m=1.5e-6, detail=0.6))
    table.save(tmp_path / "t.exr")
    image, wr = furnace(tmp_path / "t.exr", theta, samples=100)
    wi, cell = hemisphere(1200)
    xyz = (radiance.f_cos_xyz(table, wi, wr) * cell[..., None]).sum((0, 1))
    assert (image @ luminance_row()).mean() == pytest.approx(xyz[1], rel=0.01)
    rendered = np.linalg.solve(xyz_to_rgb_matrix(), image.mean((0, 1)))
    white = np.array(table.info["colour"]["white_xyz"])
    assert (rendered / white <= 1.01).all()


@pytest.fixture(scope="module")
def preset_table(tmp_path_factory):
    """Paths of the presets' tables, baked once each."""
    made, folder = {}, tmp_path_factory.mktemp("presets")

    def path(name):
        if name not in made:
            made[name] = folder / f"{name}.exr"
            bake(make_preset(name, 24e-6, 270), BakeParameters(sigma_s_m=1.5e-6, detail=0.6)).save(made[name])
        return made[name]

    return path


@pytest.mark.slow
@pytest.mark.parametrize("theta", [0, 40, 80])
@pytest.mark.parametrize("name", sorted(PRESETS))
def test_every_preset_equals_the_quadrature_and_gains_nothing(blender, preset_table, name, theta):
    path = preset_table(name)
    table = SpectralTable.load(path)
    image, wr = furnace(path, theta, samples=144)
    wi, cell = hemisphere(1500)
    xyz = (radiance.f_cos_xyz(table, wi, wr) * cell[..., None]).sum((0, 1))
    assert (image @ luminance_row()).mean() == pytest.approx(xyz[1], rel=0.01)
    rendered = np.linalg.solve(xyz_to_rgb_matrix(), image.mean((0, 1)))
    assert (rendered / table.info["colour"]["white_xyz"] <= 1.01).all()


def test_swapping_light_and_viewer_changes_nothing(blender, tmp_path):
    """f is reciprocal: radiance / cos_i stays when sun and camera change places, energy conservation on."""
    table = bake(make_preset("snake", 30e-6, 400), BakeParameters(sigma_s_m=2e-6, detail=0.6, level="poly2"))
    table.save(tmp_path / "t.exr")
    directions = np.array([(0.2, 0.3, 0.5), (-0.6, 0.1, 0.45)])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    plane = scenes.add_plane(half=1.0)
    f = []
    for light, view in (directions, directions[::-1]):
        for ob in [o for o in bpy.data.objects if o.type in {"LIGHT", "CAMERA"}]:
            bpy.data.objects.remove(ob)
        scenes.add_sun(light)
        scenes.add_camera(view, extent=0.1)
        materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE", environment=0)
        f.append(scenes.render(4).mean((0, 1)) / light[2])
    assert f[0].max() > 1e-3
    assert f[0] == pytest.approx(f[1], rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("theta", [0, 60, 80])
def test_real_scan_equals_the_quadrature_and_gains_nothing(blender, scan_dir, tmp_path_factory, theta):
    from precompute.readers import read_scan

    path = tmp_path_factory.getbasetemp() / "xenopeltis.exr"
    if not path.exists():
        scan = read_scan(scan_dir / "xenopeltis_65um_818.69nm.png", size_m=(65e-6, 65e-6), height_m=818.69e-9)
        bake(scan, BakeParameters(level="poly2", clip_percent=99.9, detail=0.6)).save(path)
    table = SpectralTable.load(path)
    image, wr = furnace(path, theta, samples=100)
    wi, cell = hemisphere(1500)
    xyz = (radiance.f_cos_xyz(table, wi, wr) * cell[..., None]).sum((0, 1))
    assert (image @ luminance_row()).mean() == pytest.approx(xyz[1], rel=0.01)
    rendered = np.linalg.solve(xyz_to_rgb_matrix(), image.mean((0, 1)))
    assert (rendered / table.info["colour"]["white_xyz"] <= 1.01).all()
