# SPDX-License-Identifier: GPL-3.0-or-later
"""An image of a table is read again where its file is another one, and only there."""

import os

import bpy
import numpy as np
import pytest

from tests.support.blender import extension, scenes, tables


@pytest.fixture
def applied(blender, tmp_path):
    """A table's path, and a function that applies it."""
    extension.load()
    from diffraction_shader.addon.materials import material

    path = tmp_path / "t.exr"
    tables.make_table(path, tables.gentle)
    made = bpy.data.materials.new("m")

    def apply(implementation="NODES"):
        return material.apply(made, path, material.Settings(implementation=implementation))

    return path, apply


def images():
    return [bpy.data.images[name] for name in ("t", "t.importance")]


def values(image):
    """Its numbers; Blender holds them from then on."""
    pixels = np.array(image.pixels[:], np.float32)
    assert image.has_data
    return pixels.reshape(image.size[1], image.size[0], 4)[..., :3]


def twice(u, v, w):
    return 2.0 * tables.gentle(u, v, w)


@pytest.mark.parametrize("implementation", ["NODES", "OSL"])
def test_an_image_of_the_same_file_is_not_read_again(applied, implementation):
    _, apply = applied
    apply(implementation)
    for image in images():
        values(image)
    apply(implementation)
    assert all(image.has_data for image in images())  # what is read again holds nothing till it is asked for
    assert [image.packed_file is not None for image in images()] == [implementation == "NODES"] * 2


@pytest.mark.parametrize("implementation", ["NODES", "OSL"])
def test_a_table_written_anew_is_read_again(applied, implementation):
    path, apply = applied
    apply(implementation)
    before = values(images()[0])
    table = tables.make_table(path, twice)
    apply(implementation)
    after = values(images()[0])
    np.testing.assert_array_equal(after, table.atlas.astype(np.float32))
    assert np.abs(after - before).max() > 0.0
    assert [image.packed_file is not None for image in images()] == [implementation == "NODES"] * 2
    if implementation == "NODES":
        assert images()[0].packed_file.data == path.read_bytes()


def test_a_clock_of_coarse_steps_hides_no_new_table(applied):
    """Time, size and number of the file are those of before, as two bakes within a step of the clock may have it."""
    path, apply = applied
    apply()
    first, content = os.stat(path), path.read_bytes()
    other = path.parent / "other" / "t.exr"
    table = tables.make_table(other, twice)
    assert len(other.read_bytes()) == len(content)
    path.write_bytes(other.read_bytes())  # into the same file
    path.with_suffix(".json").write_text(other.with_suffix(".json").read_text())
    os.utime(path, ns=(first.st_atime_ns, first.st_mtime_ns))
    now = os.stat(path)
    assert (now.st_mtime_ns, now.st_size, now.st_ino) == (first.st_mtime_ns, first.st_size, first.st_ino)
    apply()
    np.testing.assert_array_equal(values(images()[0]), table.atlas.astype(np.float32))


def test_a_file_that_was_mended_is_read_again(applied):
    """The table says the same: only the file is another."""
    path, apply = applied
    whole = path.read_bytes()
    apply("OSL")
    path.write_bytes(whole[:-2000] + bytes(2000))
    apply("OSL")
    damaged = values(images()[0])
    path.write_bytes(whole)
    os.utime(path, ns=(1, 1))
    apply("OSL")
    assert np.abs(values(images()[0]) - damaged).max() > 0.0


def test_an_image_that_was_painted_over_is_read_again(applied):
    _, apply = applied
    apply("OSL")
    image = images()[0]
    before = values(image)
    image.pixels[:4] = (9.0, 9.0, 9.0, 1.0)
    apply("OSL")
    np.testing.assert_array_equal(values(image), before)


def test_files_that_know_no_stamp_are_read_once(applied):
    _, apply = applied
    apply()
    for image in images():
        del image["diffraction_read"]
        values(image)
    apply()
    assert not any(image.has_data for image in images())
    for image in images():
        values(image)
    apply()
    assert all(image.has_data for image in images())


def test_a_bake_that_is_undone_is_read_again(applied, tmp_path):
    """Undo brings the image of the table before back; the file is that of after."""
    path, apply = applied
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "s.blend"))
    ob = scenes.add_plane()
    ob.data.materials.append(bpy.data.materials["m"])
    apply()
    bpy.ops.ed.undo_push(message="apply")
    table = tables.make_table(path, twice)
    extension.load()
    from diffraction_shader.addon.materials import material

    apply()
    bpy.ops.ed.undo_push(message="apply again")
    bpy.ops.ed.undo()
    material.apply(bpy.data.materials["m"], path, material.Settings(implementation="NODES"))
    assert images()[0].packed_file.data == path.read_bytes()
    np.testing.assert_array_equal(values(images()[0]), table.atlas.astype(np.float32))


def test_a_linked_image_stays_the_librarys(applied, tmp_path):
    path, apply = applied
    apply()
    bpy.data.materials["m"].use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "library.blend"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with bpy.data.libraries.load(str(tmp_path / "library.blend"), link=True) as (_, into):
        into.materials = ["m"]
    linked = [image for image in bpy.data.images if image.library is not None]
    assert len(linked) == 2
    tables.make_table(path, twice)
    marks = [image["diffraction_read"] for image in linked]
    from diffraction_shader.addon.materials import material

    material.apply(bpy.data.materials.new("own"), path, material.Settings(implementation="NODES"))
    own = [image for image in bpy.data.images if image.library is None and image.name.startswith("t")]
    assert len(own) == 2 and [image["diffraction_read"] for image in linked] == marks
    assert own[0].packed_file.data == path.read_bytes() != linked[0].packed_file.data


def test_the_packed_table_stays_where_its_file_is_gone(applied, tmp_path):
    """A .blend that travelled alone: Apply takes what it holds."""
    _, apply = applied
    apply()
    table = images()[0].packed_file.data
    bpy.data.materials["m"].use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "s.blend"))
    for each in tmp_path.glob("t.*"):
        each.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "s.blend"))
    from diffraction_shader.addon import paths
    from diffraction_shader.addon.materials import material

    shown = bpy.data.materials["m"]
    material.set_table(shown, paths.readable(material.table_path(shown)))
    assert len(bpy.data.images) == 2
    assert bpy.data.images["t"].packed_file.data == table


@pytest.mark.parametrize("implementation", ["NODES", "OSL"])
def test_who_stops_between_the_steps_leaves_what_is_whole(applied, implementation):
    """A window prepares a table in steps; a file may be loaded, or Blender closed, between any two of them."""
    path, apply = applied
    from diffraction_shader.addon.materials import material

    settings = material.Settings(implementation=implementation)
    for rests in range(4):
        steps = material.table_group_in_steps(path, settings)
        assert len(list(zip(range(rests), steps, strict=False))) == min(rests, 3)
        steps.close()
        made = apply(implementation)
        assert made.node_tree.nodes["Diffraction"].node_tree is material.table_group(path, settings)
        assert [image.packed_file is not None for image in images()] == [implementation == "NODES"] * 2
        bpy.data.batch_remove([*bpy.data.node_groups, *bpy.data.images])
        made.node_tree.nodes.clear()
