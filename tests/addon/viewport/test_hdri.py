# SPDX-License-Identifier: GPL-3.0-or-later
"""The viewport under images of the surroundings against numpy's sums over all directions, pixel by pixel."""

import bpy
import colour
import numpy as np
import pytest

from precompute.light.colour import xyz_to_rgb_matrix
from tests.support.blender import drawing, materials, scenes, tables
from tests.support.blender.worlds import picture_world, spotted_sky
from tests.truth import radiance
from tests.truth.hemisphere import around_the_mirror

SIZE = 16

STUDIOS = ("city", "courtyard", "forest", "interior", "night", "studio", "sunrise", "sunset")


def horizon():
    """A bright warm sky over dark ground: what lies below a surface's horizon must not be blurred into its light."""
    lat = ((np.arange(64) + 0.5) / 64 - 0.5) * np.pi
    rows = np.where(lat[:, None] > 0.0, (2.0, 1.5, 1.0), (0.02, 0.03, 0.05))
    return np.broadcast_to(rows[:, None], (64, 128, 3)).astype(np.float32)


def leaves():
    """Small bright gaps, each some degrees wide, in a dark canopy over darker ground."""
    rng = np.random.default_rng(3)
    rgb = np.full((128, 256, 3), 0.05, np.float32)
    for row, column in zip(rng.integers(60, 120, 150), rng.integers(4, 252, 150), strict=True):
        rgb[row : row + 3, column : column + 4] = rng.uniform(1.0, 12.0) * np.array((0.9, 1.0, 1.2))
    return rgb


def own_pictures():
    return {
        "even": np.ones((16, 32, 3), np.float32), "horizon": horizon(), "leaves": leaves(), "spots": spotted_sky()
    }  # fmt: skip


def studio_pixels(name):
    """Linear ``(rows, cols, 3)`` of one of Blender's studio lights."""
    from diffraction_shader.addon.viewport.data import sky

    path = next((each.path for each in bpy.context.preferences.studio_lights if each.name == f"{name}.exr"), None)
    return None if path is None else sky.read_pixels(sky.Sky("", path, (), (1.0,) * 9, (1.0, 1.0, 1.0)))


def scene_with(table_path):
    ball = scenes.add_sphere()
    scenes.add_camera((0.4, -1.0, 0.5))
    materials.diffracting(ball, table_path, fresnel="NONE", environment=4)
    return ball


def chosen(every):
    """Every so many of the pixels well inside the ball's rim."""
    y, x = np.mgrid[0:SIZE, 0:SIZE] + 0.5 - SIZE / 2
    rows, columns = np.nonzero(np.hypot(x, y) < 0.8 * SIZE / 2.2)
    return rows[::every], columns[::every]


def summed(table, ball, at, pictures, radii, turns):
    """RGB ``(pixels, 3)`` under each of the pictures: bright pixels one by one, the rest as it is looked up."""
    from diffraction_shader.addon.lights import hot_spots
    from diffraction_shader.addon.viewport.data import sky

    _, _, t, b, n = scenes.sphere_frames(ball, SIZE)
    towards = -scenes.camera_rays(SIZE)[1]
    to_rgb = xyz_to_rgb_matrix()
    found = {name: [] for name in pictures}
    parts = {}
    for name, rgb in pictures.items():
        # A pixel brighter than others by far is a light of its own, whose place counts and no lookup about it.
        bright = rgb.max(-1) > 30.0 * rgb.mean()
        rest = np.where(bright[..., None], 0.0, rgb)
        rows, columns = np.nonzero(bright)
        size = hot_spots._texel_sizes(*rgb.shape[:2])[rows, None]
        parts[name] = rest, hot_spots._directions(rows, columns, *rgb.shape[:2]), rgb[rows, columns] * size
    for row, column in zip(*at, strict=True):
        frame = np.stack([t[row, column], b[row, column], n[row, column]])
        wr = frame @ towards
        wi, cell = around_the_mirror(wr, radii, turns)
        f_cos = radiance.gamut_step(radiance.f_cos_xyz(table, wi, wr), to_rgb) * cell[:, None]
        for name, (rest, places, light) in parts.items():
            by_rest = (f_cos * sky.equirectangular(rest, wi @ frame)).sum(0)
            by_bright = radiance.gamut_step(radiance.f_cos_xyz(table, places @ frame.T, wr), to_rgb) * light
            found[name].append(by_rest + by_bright.sum(0))
    return {name: np.array(values) for name, values in found.items()}


def differs(drawn, wanted):
    """Mean Delta E 2000, the brightest shown as white."""
    white = np.percentile(wanted, 99)
    lab = [
        colour.XYZ_to_Lab(colour.RGB_to_XYZ(np.clip(rgb / white, 0.0, 1.0), "sRGB", apply_cctf_decoding=False))
        for rgb in (drawn, wanted)
    ]
    return colour.delta_E(*lab, method="CIE 2000").mean()


def test_pictures_of_our_own(renderer, tmp_path):
    """A picture's mean within 1 % a channel, Delta E below 1; a single drawing within 5 % and 3."""
    table = tables.make_table(tmp_path / "t.exr", tables.gentle, albedo="own")
    ball, at = scene_with(tmp_path / "t.exr"), chosen(every=4)
    wanted = summed(table, ball, at, own_pictures(), radii=300, turns=270)
    for name, rgb in own_pictures().items():
        picture_world(rgb)
        bpy.context.view_layer.update()
        drawn = drawing.mean_of_many(renderer, SIZE)[at]
        assert drawn.mean(0) == pytest.approx(wanted[name].mean(0), rel=0.01), name
        assert differs(drawn, wanted[name]) < 1.0, name
        once = drawing.alone(renderer, SIZE, points=16)[at]
        assert once.mean(0) == pytest.approx(wanted[name].mean(0), rel=0.05), name
        assert differs(once, wanted[name]) < 3.0, name


def test_a_gathered_view_is_as_bright_as_a_picture(renderer, tmp_path):
    """Half floats whose rest is cut off made 64 drawings 1 % darker than they are."""
    tables.make_table(tmp_path / "t.exr", tables.gentle, albedo="own")
    scene_with(tmp_path / "t.exr")
    picture_world(horizon())
    bpy.context.view_layer.update()
    gathered = drawing.alone(renderer, SIZE, points=1, gathers="view")
    while renderer.gathering.wants_more("view"):
        gathered = drawing.alone(renderer, SIZE, points=1, gathers="view")
    at = chosen(every=1)
    picture = drawing.mean_of_many(renderer, SIZE, together=64, points=1)[at]
    assert gathered[at].mean(0) == pytest.approx(picture.mean(0), rel=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("wide", [True, False])
def test_studio_lights_of_blender(renderer, tmp_path, snake, wide):
    """Wide lobes and the narrow orders of the snake: means within 3 % a channel, Delta E of at most 3."""
    table, path = snake
    if wide:
        path = tmp_path / "t.exr"
        table = tables.make_table(path, tables.gentle, albedo="own")
    pictures = {name: pixels for name in STUDIOS if (pixels := studio_pixels(name)) is not None}
    if not pictures:
        pytest.skip("this Blender brings no studio lights")
    ball, at = scene_with(path), chosen(every=2)
    wanted = summed(table, ball, at, pictures, *((400, 360) if wide else (700, 900)))
    for name, rgb in pictures.items():
        picture_world(rgb)
        bpy.context.view_layer.update()
        drawn = drawing.mean_of_many(renderer, SIZE)[at]
        error, colours = drawn.mean(0) / wanted[name].mean(0) - 1.0, differs(drawn, wanted[name])
        print(f"{name}: means {(100 * error).round(1)} %, Delta E {colours:.2f}")
        assert abs(error).max() < 0.03 and colours <= 3.0, name


def test_directions_of_several_drawings_are_one_lattice(blender):
    """As far from one another as those of one lattice, whatever their numbers; the first lie among all."""
    from diffraction_shader.addon.viewport import gathering

    for together, directions in ((1, 32), (4, 32), (16, 32), (64, 8), (10, 16)):
        moves = np.array(gathering.moves(together, directions))
        assert moves.shape == (together, 2) and moves.min() >= 0.0 and moves.max() < 1.0
        i = np.arange(directions)
        x = (i + (0.5 + moves[:, :1]) % 1.0) / directions
        y = (0.5 + moves[:, 1:] + 0.6180339887 * i) % 1.0
        n = together * directions
        assert np.sort(x.ravel()) == pytest.approx((np.arange(n) + 0.5) / n, abs=1e-6)
        apart_x, apart_y = x.reshape(-1, 1) - x.reshape(1, -1), y.reshape(-1, 1) - y.reshape(1, -1)
        apart = np.hypot(apart_x, (apart_y + 0.5) % 1.0 - 0.5)[~np.eye(n, dtype=bool)]
        assert apart.min() > 0.6 / np.sqrt(n)  # of the best lattice: 1.07
    assert gathering.moves(1, 32) == ((0.0, 0.0),)
