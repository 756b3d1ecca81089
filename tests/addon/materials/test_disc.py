# SPDX-License-Identifier: GPL-3.0-or-later
"""A disc with grooves around its axis, 1.6 um apart: colours where the grating equation puts them."""

import bpy
import numpy as np
import pytest

from precompute.bake.baking import bake
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from tests.support.blender import materials, scenes


@pytest.fixture(scope="module")
def grooves(tmp_path_factory):
    path = tmp_path_factory.mktemp("disc") / "disc.exr"
    scan = make_preset("sinusoid", 48e-6, 520, period_um=1.6, amplitude_nm=60.0)
    bake(scan, BakeParameters(sigma_s_m=4e-6)).save(path)
    return path


def lamp_over_the_disc(height=1.0, x=0.0):
    light = bpy.data.lights.new("lamp", "POINT")
    light.energy, light.shadow_soft_size = 100.0, 0.0
    light.cycles.use_multiple_importance_sampling = False
    ob = bpy.data.objects.new("lamp", light)
    ob.location = (x, 0, height)
    bpy.context.scene.collection.objects.link(ob)


def test_rings_under_a_lamp_over_the_centre(blender, grooves):
    """Seen from above along the axis, first order: wavelength = 1.6 um sin(atan(r / h)) at the distance r."""
    lamp_over_the_disc()
    camera = scenes.add_camera(extent=1.4)
    camera.rotation_euler = (0, 0, 0)
    plane = scenes.add_plane(half=1.0)
    materials.diffracting(plane, grooves, fresnel="CONDUCTOR", orientation="RADIAL", environment=0)
    image = scenes.render(256)
    axis = ((np.arange(256) + 0.5) / 256 - 0.5) * 1.4
    distance = np.hypot(*np.meshgrid(axis, axis))
    wavelength = 1600 * np.sin(np.arctan(distance))
    # The equation holds at every azimuth: means over rings 8 nm wide, and their spread.
    bins = np.arange(400, 700, 8)
    ring = np.digitize(wavelength, bins)
    mean = np.array([image[ring == k].mean(0) for k in range(1, len(bins))])
    spread = np.array([image[ring == k].std(0) for k in range(1, len(bins))])
    middle = bins[:-1] + 4
    share = mean / mean.sum(-1, keepdims=True)
    assert middle[np.argmax(share[:, 1])] == pytest.approx(535, abs=20)  # green
    assert middle[np.argmax(share[:, 2])] == pytest.approx(455, abs=25)  # blue
    assert (share[middle > 620, 0] > 0.9).all()  # red and nothing else
    assert (spread[3:-3].max(-1) < 0.35 * mean[3:-3].max(-1)).all()


def test_spokes_under_a_lamp_beside_the_axis(blender, grooves):
    """Light comes back only where lamp, axis and point lie in one plane: a spoke through the lamp's foot."""
    lamp_over_the_disc(x=0.5)
    camera = scenes.add_camera(extent=1.8)
    camera.rotation_euler = (0, 0, 0)
    plane = scenes.add_plane(half=1.0)
    materials.diffracting(plane, grooves, fresnel="CONDUCTOR", orientation="RADIAL", environment=0)
    luminance = scenes.render(128)[..., 1]
    axis = ((np.arange(128) + 0.5) / 128 - 0.5) * 1.8
    x, y = np.meshgrid(axis, axis)
    far = (np.abs(x) > 0.15) & (np.abs(x) < 0.85)  # leave out the centre and the lamp's mirror image
    on, off = far & (np.abs(y) < 0.02), far & (np.abs(y) > 0.3)
    assert luminance[on].mean() > 20 * luminance[off].mean()


def test_colours_along_a_spoke_stand_where_the_grating_equation_puts_them(blender, grooves):
    """Seen along the axis, the lamp 1.6 over x = 1: wavelength = 1.6 um sin(theta_i) all along the spoke."""
    lamp_over_the_disc(height=1.6, x=1.0)
    camera = scenes.add_camera(extent=1.8)
    camera.rotation_euler = (0, 0, 0)
    plane = scenes.add_plane(half=1.0)
    materials.diffracting(plane, grooves, fresnel="CONDUCTOR", orientation="RADIAL", environment=0)
    image = scenes.render(360)
    axis = ((np.arange(360) + 0.5) / 360 - 0.5) * 1.8
    spoke = image[178:182].mean(0)
    wavelength = 1600 * (1.0 - axis) / np.hypot(1.0 - axis, 1.6)
    seen = (axis > 0.15) & (wavelength > 400) & (wavelength < 690)
    share = spoke[seen] / spoke[seen].sum(-1, keepdims=True)
    shown = wavelength[seen]
    assert shown.min() < 420 and shown.max() > 650
    assert shown[np.argmax(share[:, 1])] == pytest.approx(535, abs=20)
    assert shown[np.argmax(share[:, 2])] == pytest.approx(455, abs=25)
    assert (share[shown > 625, 0] > 0.85).all()
