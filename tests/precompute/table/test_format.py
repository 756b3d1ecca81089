# SPDX-License-Identifier: GPL-3.0-or-later
"""The two formats of a table: what 2 added, and that 1 stays what it was."""

import json

import numpy as np
import pytest

from precompute.bake import bake
from precompute.bake.baking import assemble
from precompute.errors import TableError
from precompute.files.exr import write_half_rgb
from precompute.light.colour import adaptation, spectral_weights, table_light, white_xyz, xyz_to_rgb_matrix
from precompute.light.illuminant import Spectrum
from precompute.parameters import BakeParameters
from precompute.presets import make_preset
from precompute.table.layout import GUARD, TableLayout, put_guard
from precompute.table.table import SpectralTable

SIZES = dict(n_r=40, n_phi=64, n_w=6, r0=0.1, w0=0.4, w_min=0.1, tile_columns=2, n_theta=10, n_albedo_phi=12)

#: All that a layout of format 1 holds.
FORMAT_1 = """
n_r n_phi n_w r0 w0 w_min power scale tile_columns n_theta n_albedo_phi a_r a_w s_w tile_rows width height albedo_y
"""


def made(**more):
    """A table of noise, assembled as a bake does it."""
    layout = TableLayout(**{**SIZES, **more})
    rng = np.random.default_rng(3)
    layout, atlas = assemble(rng.random((layout.n_r, 6, 3, 64)), layout, 0.5 + 0.2 * rng.random((12, 10)))
    info = {"albedo_max": 0.7, "parameters": {}, "source": {}, "colour": {"illuminant": "A"}, "terms": 1}
    return SpectralTable(layout, atlas, info)


def test_format_1_is_read_as_it_was_and_written_as_it_was(tmp_path):
    new, old = made(), made(guarded=0)
    path = old.save(tmp_path / "old.exr")
    sidecar = json.loads(path.with_suffix(".json").read_text())
    assert sidecar["format_version"] == 1
    assert set(sidecar["layout"]) == set(FORMAT_1.split())
    assert sidecar["layout"]["height"] == sidecar["layout"]["albedo_y"] + 14
    again = SpectralTable.load(path)
    assert again.layout == old.layout
    assert again.format_version == 1
    u, v, w = np.random.default_rng(1).uniform(-0.9, 0.9, (3, 200))
    assert np.array_equal(again.transform(u, v, w), new.transform(u, v, w))
    directions = np.stack([u, v, np.abs(w)], -1)
    assert np.array_equal(again.albedo(directions), new.albedo(directions))
    first = path.read_bytes()
    assert again.save(path).read_bytes() == first
    assert table_light(again.info["colour"]) == "A"  # a matrix of its own


def test_guard_stands_alone_at_the_place_that_the_sidecar_names(tmp_path):
    path = made(n_reflectance=91, n_albedo=2).save(tmp_path / "new.exr")
    sidecar = json.loads(path.with_suffix(".json").read_text())["layout"]
    assert tuple(sidecar[f"guard_{name}"] for name in ("high", "middle", "low")) == GUARD
    atlas = SpectralTable.load(path).atlas.astype(float)
    x, y = sidecar["guard_x"], sidecar["guard_y"]
    assert tuple(atlas[y, x]) == GUARD
    around = atlas[y - 2 : y + 3, x - 2 : x + 3].copy()
    around[2, 2] = 0.0
    assert not around.any()


@pytest.mark.parametrize("spoil", ["half", "8 bit", "sRGB", "clipped", "matrix"])
def test_guard_shows_what_was_done_to_the_image(spoil):
    table = made(n_r=41)
    lay, image = table.layout, table.atlas.astype(float)
    if spoil == "half":
        even = image[: lay.height // 2 * 2, : lay.width // 2 * 2]
        image = even.reshape(lay.height // 2, 2, lay.width // 2, 2, 3).mean((1, 3))
    elif spoil == "8 bit":
        image = np.rint(np.clip(image, 0, 1) * 255) / 255
    elif spoil == "sRGB":
        image = np.where(image > 0.04045, ((np.abs(image) + 0.055) / 1.055) ** 2.4, image / 12.92)
    elif spoil == "clipped":
        image = np.maximum(image, 0.0)
    else:
        image = image @ xyz_to_rgb_matrix("ACEScg").T
    # The bilinear lookup at the guard's place, in parts of the image.
    x = (lay.guard_x + 0.5) / lay.width * image.shape[1] - 0.5
    y = (lay.guard_y + 0.5) / lay.height * image.shape[0] - 0.5
    i, j = int(x), int(y)
    fx, fy = x - i, y - j
    seen = (image[j, i] * (1 - fx) + image[j, i + 1] * fx) * (1 - fy)
    seen = seen + (image[j + 1, i] * (1 - fx) + image[j + 1, i + 1] * fx) * fy
    assert np.abs(seen - GUARD).max() > 0.1


def test_colours_are_adapted_to_d65_and_say_so():
    """Under any light but a monochromatic one XYZ is that of D65 after Bradford; grey is D65's white."""
    scan = make_preset("stam_bumps", 12e-6, 64)
    tables = {light: bake(scan, BakeParameters(illuminant=light, detail=0.4)) for light in ("D65", "A")}
    u = np.array([0.0, 0.1, 0.3, -0.2])
    for light, table in tables.items():
        assert table.info["colour"]["adapted"] == "D65"
        assert table.light == "D65"
        assert table.info["colour"]["white_xyz"] == pytest.approx(white_xyz("D65"))
        assert table.info["colour"]["illuminant"] == light
    day, lamp = (tables[light].transform(u, 0.1 * u, -1.9) for light in ("D65", "A"))
    assert day != pytest.approx(lamp, rel=0.02)
    # The matrix of old from XYZ under A, against the one matrix of all lights.
    back = np.linalg.solve(adaptation("A"), lamp.T)
    assert xyz_to_rgb_matrix() @ lamp.T == pytest.approx(xyz_to_rgb_matrix(illuminant="A") @ back, rel=1e-3, abs=1e-3)


def test_adaptation_turns_white_into_white_and_leaves_lasers_alone():
    assert np.array_equal(adaptation("D65"), np.eye(3))
    for light in ("A", "D50", "E", "FL11"):
        assert adaptation(light) @ white_xyz(light) == pytest.approx(white_xyz("D65"), rel=1e-12)
        assert adaptation(light) @ spectral_weights(illuminant=light)[1].sum(0) == pytest.approx(white_xyz("D65"))
    nm = np.arange(380.0, 781.0)
    laser = Spectrum(tuple(nm * 1e-9), tuple(np.exp(-(((nm - 532.0) / 2.0) ** 2))))
    assert adaptation(laser) is None


def test_negative_components_of_saturated_colours_survive():
    """Bradford may take a pure colour out of the positive octant; clipping it would turn its hue."""
    layout = TableLayout(**SIZES)
    texels = np.zeros((40, 6, 3, 64))
    texels[:, :, 0], texels[:, :, 1] = 0.5, 0.5  # no Z: yellow
    turn = adaptation("A")
    layout, atlas = assemble(texels, layout, np.full((12, 10), 0.5), turn)
    value = atlas[5, 5].astype(float) * layout.scale
    assert value == pytest.approx(turn @ [0.5, 0.5, 0.0], rel=1e-3)
    assert value.min() < 0


def test_sidecars_that_mix_both_formats_are_refused(tmp_path):
    path = made().save(tmp_path / "t.exr")
    text = path.with_suffix(".json").read_text().replace('"format_version": 2', '"format_version": 1')
    write_half_rgb(path, np.zeros((121, 80, 3), np.float16), text)
    path.with_suffix(".json").write_text(text)
    with pytest.raises(TableError, match="contradicts itself"):
        SpectralTable.load(path)


def test_a_guard_may_be_put_where_none_is_asked_for():
    layout = TableLayout(**SIZES, guarded=0)
    atlas = np.ones((layout.height, layout.width, 3), np.float16)
    put_guard(atlas, layout)
    assert (atlas == 1).all()
