# SPDX-License-Identifier: GPL-3.0-or-later
"""Layout, lookups and files of the spectral table."""

import json
import shutil

import numpy as np
import pytest

from precompute.errors import OutputError, TableError
from precompute.table.layout import TableLayout, near_square_columns
from precompute.table.table import SpectralTable


def layout(**changes):
    numbers = dict(n_r=20, n_phi=24, n_w=7, r0=0.2, w0=0.4, w_min=0.1, power=1.0, scale=0.5, tile_columns=3)
    return TableLayout(**{**numbers, **changes})


def smooth_table(power=1.0, value=lambda u, v, w: 1.0 + 0.3 * u - 0.2 * v + 0.1 * w * u):
    """A table filled from a function of (u, v, |w|), texel by texel, by the contract and not by the code."""
    lay = layout(n_r=200, n_phi=360, n_w=30, power=power, tile_columns=7)
    atlas = np.zeros((lay.height, lay.width, 3), np.float32)
    for k in range(lay.n_w):
        w = lay.w0 * np.sinh(k / lay.a_w + lay.s_w)
        x0, y0 = (k % 7) * 200, (k // 7) * 362
        for row in range(-1, 361):
            phi = 2 * np.pi * row / 360
            r = lay.r0 * np.sinh(np.arange(200) / lay.a_r)
            texel = value(r * np.cos(phi), r * np.sin(phi), w) / (lay.scale * w**power)
            atlas[y0 + row + 1, x0 : x0 + 200] = texel[:, None] * np.array([0.5, 1.0, 2.0])
    return SpectralTable(lay, atlas), value


@pytest.mark.parametrize("power", [0.0, 1.0])
def test_lookup_gives_back_the_function_the_texels_were_made_from(power):
    table, value = smooth_table(power)
    rng = np.random.default_rng(1)
    r, phi, w = rng.uniform(0, 2, 500), rng.uniform(-np.pi, np.pi, 500), rng.uniform(0.1, 2, 500)
    u, v = r * np.cos(phi), r * np.sin(phi)
    got = table.transform(u, v, -w)
    assert got == pytest.approx(value(u, v, w)[:, None] * np.array([0.5, 1.0, 2.0]), rel=0.02, abs=0.004)


def test_lookup_is_continuous_over_the_seam_of_the_angles():
    table, _ = smooth_table()
    below, above = table.transform(-0.7, -1e-9, -1.0), table.transform(-0.7, 1e-9, -1.0)
    assert below == pytest.approx(above, rel=1e-6)


def test_mapping_ends_where_it_must():
    lay = layout()
    assert lay.radii[0] == 0
    assert lay.radii[-1] == pytest.approx(2)
    assert lay.slices[0] == pytest.approx(0.1)
    assert lay.slices[-1] == pytest.approx(2)
    assert lay.column(lay.radii) == pytest.approx(np.arange(20), abs=1e-9)
    assert lay.slice_coordinate(-lay.slices) == pytest.approx(np.arange(7), abs=1e-9)
    assert lay.row(lay.angles) == pytest.approx(np.arange(24), abs=1e-9)
    assert lay.row(-lay.angles[1]) == pytest.approx(23)
    assert lay.column(5.0) == 19
    assert lay.slice_coordinate(0.001) == 0


@pytest.mark.parametrize("more", [{}, {"n_albedo": 3, "n_reflectance": 91}, {"guarded": 0}])
def test_tiles_do_not_overlap_and_leave_room_for_the_albedo(more):
    lay = layout(**more)
    taken = np.zeros((lay.height, lay.width), int)
    for k in range(lay.n_w):
        x, y = lay.tile_origin(k)
        taken[y : y + lay.tile_height, x : x + lay.n_r] += 1
    for tile in range(lay.n_albedo):
        first = lay.albedo_y + tile * lay.albedo_height
        taken[first : first + lay.n_albedo_phi + 2, : lay.n_theta] += 1
    if lay.n_reflectance:
        taken[lay.reflectance_y - 1 : lay.reflectance_y + 2, : lay.n_reflectance] += 1
    if lay.guarded:
        taken[lay.guard_y - 2 : lay.guard_y + 3, lay.guard_x - 2 : lay.guard_x + 3] += 1
    assert taken.max() == 1
    assert taken[-1].max() == 1


def test_columns_keep_the_atlas_near_a_square():
    columns = near_square_columns(140, 864, 17)
    width, height = columns * 140, -(-17 // columns) * 866
    assert 0.3 < width / height < 3


@pytest.fixture
def stored(tmp_path):
    table, _ = smooth_table()
    info = {"albedo_max": 0.9, "parameters": {}, "source": {}, "colour": {"illuminant": "D65"}, "terms": 1}
    table = SpectralTable(table.layout, table.atlas.astype(np.float16), info)
    return table, table.save(tmp_path / "t.exr")


def test_files_give_back_the_table(stored):
    table, path = stored
    for name in (path, path.with_suffix(".json")):
        again = SpectralTable.load(name)
        assert (again.atlas == table.atlas).all()
        assert again.layout == table.layout
        assert again.albedo_max == 0.9


def test_row_zero_is_the_bottom_of_the_picture(stored):
    import OpenEXR

    table, path = stored
    with OpenEXR.File(str(path)) as image:
        pixels = image.channels()["RGB"].pixels
    assert (pixels[-1] == table.atlas[0]).all()


def change(path, **entries):
    sidecar = json.loads(path.with_suffix(".json").read_text())
    sidecar.update(entries)
    path.with_suffix(".json").write_text(json.dumps(sidecar))


def test_other_versions_are_refused_by_number(stored):
    change(stored[1], format_version=99)
    with pytest.raises(TableError, match="version 99"):
        SpectralTable.load(stored[1])


def test_missing_and_damaged_files_are_refused(stored, tmp_path):
    _, path = stored
    with pytest.raises(TableError, match="does not exist"):
        SpectralTable.load(tmp_path / "other.exr")
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(TableError):
        SpectralTable.load(path)
    damaged = bytearray(whole)
    damaged[-100] ^= 0xFF
    path.write_bytes(damaged)
    with pytest.raises(TableError, match="damaged"):
        SpectralTable.load(path)
    path.unlink()
    with pytest.raises(TableError, match="does not exist"):
        SpectralTable.load(path)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "null", '{"format_version": 1}', "[" * 100000])
def test_a_sidecar_that_is_none_is_refused(stored, text):
    stored[1].with_suffix(".json").write_text(text)
    with pytest.raises(TableError):
        SpectralTable.load(stored[1])


def test_a_bake_that_died_between_its_files_left_the_new_table(stored, tmp_path):
    table, path = stored
    newer = SpectralTable(table.layout, table.atlas, {**table.info, "albedo_max": 0.5}).save(tmp_path / "new" / "t.exr")
    shutil.copy(newer, path)
    assert SpectralTable.load(path).albedo_max == 0.5


def test_unwritable_folder_is_said(stored, tmp_path):
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(OutputError):
        stored[0].save(tmp_path / "file" / "t.exr")
