# SPDX-License-Identifier: GPL-3.0-or-later
"""How the scan lies on the surface: each way puts the light where a grating would send it."""

import bpy
import numpy as np
import pytest

from tests.support.blender import materials, scenes, tables


def one_sided(u, v, w):
    """Light at u > 0 only: seen from above, surfaces shine whose t points away from the lamp."""
    return np.where(u > 0.1, 1.0, 0.0)[..., None] * np.asarray(tables.WHITE)


@pytest.fixture
def plane(blender, tmp_path):
    tables.make_table(tmp_path / "t.exr", one_sided)
    camera = scenes.add_camera(extent=1.8)
    camera.rotation_euler = (0, 0, 0)  # x to the right, y up
    camera.location.x = 0.013  # its pixels' diagonal is not the edge between the two triangles
    return scenes.add_plane(half=1.0)


def shines_for(plane, tmp_path, towards, **settings):
    """Picture of the plane with a sun at an azimuth (degrees), one at a time."""
    for old in [ob for ob in bpy.data.objects if ob.type == "LIGHT"]:
        bpy.data.objects.remove(old)
    azimuth = np.radians(towards)
    scenes.add_sun((0.5 * np.cos(azimuth), 0.5 * np.sin(azimuth), 0.85))
    materials.diffracting(plane, tmp_path / "t.exr", fresnel="NONE", environment=0, **settings)
    return scenes.render(16)[..., 1] > 0.1


def test_rotation_turns_the_scan(plane, tmp_path):
    """Unturned t is +x, so a lamp at 180 degrees shines; a quarter turn later it is the one at 270."""
    assert shines_for(plane, tmp_path, 180).all()
    assert not shines_for(plane, tmp_path, 270).any()
    assert shines_for(plane, tmp_path, 270, rotation=np.pi / 2).all()
    assert not shines_for(plane, tmp_path, 90, rotation=np.pi / 2).any()


def test_attribute(plane, tmp_path):
    attribute = plane.data.attributes.new("comb", "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", np.tile(np.float32((0, -1, 0.5)), 4))
    settings = {"orientation": "ATTRIBUTE", "attribute": "comb"}
    assert shines_for(plane, tmp_path, 90, **settings).all()
    assert not shines_for(plane, tmp_path, 270, **settings).any()
    plane.rotation_euler = (0, 0, np.pi / 2)  # the attribute turns with the object: now it points to +x
    assert shines_for(plane, tmp_path, 180, **settings).all()
    plane.rotation_euler = (0, 0, 0)
    plane.scale = (1, 0.2, 1)  # and shears with it: (1, -1, 0) becomes (1, -0.2, 0), nearly +x
    attribute.data.foreach_set("vector", np.tile(np.float32((1, -1, 0)), 4))
    azimuth = np.degrees(np.arctan2(-0.2, 1.0))
    for past, bright in ((75, True), (105, False), (-75, True), (-105, False)):  # u > 0.1 ends near 78 degrees
        assert (shines_for(plane, tmp_path, azimuth + 180 + past, **settings)[7:9].mean() > 0.5) == bright


def test_radial_points_outwards(plane, tmp_path):
    """A lamp at +x: t points away from it, so from the axis, on the left half only."""
    image = shines_for(plane, tmp_path, 0, orientation="RADIAL")
    assert image[6:10, :5].all()
    assert not image[6:10, 11:].any()
    image = shines_for(plane, tmp_path, 90, orientation="RADIAL")
    assert image[:5, 6:10].all()
    assert not image[11:, 6:10].any()


def test_angle_image(plane, tmp_path):
    """Left half unturned, right half turned by half a turn (grey 0.5)."""
    image = bpy.data.images.new("angles", 8, 8, is_data=True, float_buffer=True)
    pixels = np.zeros((8, 8, 4), np.float32)
    pixels[:, 4:, :3] = 0.5
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    shown = shines_for(plane, tmp_path, 180, orientation="TEXTURE", angle_image="angles")
    assert shown[:, :7].all()
    assert not shown[:, 9:].any()


def test_missing_angle_image_is_named(plane, tmp_path):
    with pytest.raises(Exception, match="no image 'nothing'"):
        shines_for(plane, tmp_path, 180, orientation="TEXTURE", angle_image="nothing")


@pytest.mark.parametrize(
    "settings",
    [
        {"orientation": "UV", "uv_map": "UVMap", "rotation": 0.3},
        {"orientation": "RADIAL", "rotation": 0.4, "fresnel": "CONDUCTOR"},
        {"orientation": "ATTRIBUTE", "attribute": "comb", "environment": 3, "conserve_energy": False},
    ],
)
def test_settings_can_be_read_back(plane, tmp_path, settings):
    from diffraction_shader.addon.materials import material

    made = materials.diffracting(plane, tmp_path / "t.exr", **settings)
    found = material.settings_of(made)
    for name, value in settings.items():
        assert getattr(found, name) == (pytest.approx(value) if isinstance(value, float) else value)
