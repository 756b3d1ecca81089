# SPDX-License-Identifier: GPL-3.0-or-later
"""What photographs of gratings show, held against the grating equation: the pictures of docs/gallery.md rest on it."""

import math
import subprocess
import sys

import numpy as np
import pytest

from precompute.bake.baking import bake
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from tests.support.blender import materials, scenes

#: Half the angle that the bent sheet turns through, and pixels across it.
BEND, SIZE = math.radians(17.0), 192


@pytest.fixture
def gallery():
    from tools.docs.gallery import plates, stage

    return stage, plates


@pytest.fixture(scope="module")
def disc_table(tmp_path_factory):
    path = tmp_path_factory.mktemp("cd") / "cd.exr"
    bake(make_preset("cd", 24e-6, 300), BakeParameters(sigma_s_m=4e-6)).save(path)
    return path


def bent_sheet(stage):
    """Part of a cylinder about y, one unit wide as seen from above; u runs round it."""
    turn, y = np.meshgrid(np.linspace(-BEND, BEND, 257), np.linspace(-0.5, 0.5, 3))
    radius = 0.5 / math.sin(BEND)
    points = np.stack([radius * np.sin(turn), y, radius * (np.cos(turn) - 1.0)], -1)
    return stage.link("sheet", stage.grid("sheet", points, np.stack([turn, y], -1)))


def seen():
    """Turn of the surface, and mean colour, by column."""
    image = scenes.render(SIZE)
    x = (np.arange(SIZE) + 0.5) / SIZE - 0.5
    return np.arcsin(x * 2.0 * math.sin(BEND)), image[SIZE // 4 : -SIZE // 4].mean(0)


@pytest.mark.parametrize("light_deg", [0.0, 6.0])
def test_mirror_direction_is_white_and_first_order_runs_from_blue_to_red(blender, gallery, disc_table, light_deg):
    """A CD's tracks on a bent sheet: order m leaves where 1.6 um (sin a + sin(a - light)) = m wavelengths."""
    stage, _ = gallery
    sheet, light = bent_sheet(stage), math.radians(light_deg)
    scenes.add_sun((math.sin(light), 0.0, math.cos(light)))
    scenes.add_camera(extent=1.0).rotation_euler = (0.0, 0.0, 0.0)
    materials.diffracting(sheet, disc_table, fresnel="CONDUCTOR", environment=0)
    turn, colour = seen()
    path = 1600.0 * (np.sin(turn) + np.sin(turn - light))  # nm
    mirror = colour[:, 1].argmax()
    assert abs(path[mirror]) < 40.0  # the brightest place is the mirror direction, and it moves with the light
    assert colour[mirror].max() < 1.6 * colour[mirror].min()
    share = colour / colour.sum(-1, keepdims=True)
    for side in (path > 0.0, path < 0.0):
        first = side & (np.abs(path) > 400.0) & (np.abs(path) < 700.0)
        assert first.any()
        wavelength = np.abs(path[first])
        blue, green = (wavelength[share[first, channel].argmax()] for channel in (2, 1))
        assert blue == pytest.approx(455.0, abs=30.0) and green == pytest.approx(540.0, abs=30.0)
        assert (share[first][wavelength > 630.0, 0] > 0.7).all()
        assert colour[first].max() > 0.01 * colour[mirror].max()


@pytest.mark.parametrize("wavelength", [435e-9, 540e-9, 640e-9])
def test_plates_stand_where_the_grating_equation_says(gallery, wavelength):
    """Along the ruled face the unit vectors to lamp and camera add up to one wavelength a period."""
    _, plates = gallery
    place, lamp, eye = np.array([0.02, -0.01]), (0.7, -0.9, 0.3), (0.1, -1.4, 0.34)
    angle = plates.turn(place, wavelength, lamp, eye)
    along, centre = np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([*place, 0.5 * plates.HEIGHT])
    to_lamp, to_eye = (np.array(p) - centre for p in (lamp, eye))
    path = along @ (to_lamp / np.linalg.norm(to_lamp) + to_eye / np.linalg.norm(to_eye)) * plates.PERIOD
    assert abs(path) == pytest.approx(wavelength, rel=1e-6)


@pytest.mark.slow
def test_a_draft_of_the_plates_runs_from_blue_to_red(root_dir, tmp_path):
    """The script as `make docs` calls it, small."""
    import matplotlib.image

    script = root_dir / "tools" / "docs" / "gallery_page.py"
    subprocess.run(
        [sys.executable, script, "plates", "--scale", "0.06", "--samples", "2", "--out", tmp_path], check=True
    )
    assert str(root_dir).encode() not in (tmp_path / "plates.jpg").read_bytes()
    picture = matplotlib.image.imread(tmp_path / "plates.jpg")[..., :3] / 255.0
    rows, columns, _ = picture.shape
    band = picture[round(0.2 * rows) : round(0.55 * rows), round(0.17 * columns) : round(0.92 * columns)].mean(0)
    lit = band.sum(-1) > 0.3
    redness = (band[lit, 0] - band[lit, 2]) / band[lit].sum(-1)
    assert lit.mean() > 0.5
    assert np.corrcoef(np.flatnonzero(lit), redness)[0, 1] > 0.9
    assert redness[0] < -0.3 and redness[-1] > 0.3
