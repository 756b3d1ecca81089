# SPDX-License-Identifier: GPL-3.0-or-later
"""A .blend is saved, moved, appended from, linked, packed and undone, each step in a fresh Blender process."""

import os
import shutil

import numpy as np
import pytest

from tests.support.blender import life


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A project folder that no test changes, and the picture that its scene gives."""
    folder = tmp_path_factory.mktemp("made")
    image = np.array(life.run(life.make_project, user=folder / "user", path=folder / "scene.blend"))
    assert image.max() > 0.01
    return folder, image


@pytest.fixture
def project(made, tmp_path):
    """A copy of the project in a folder of another name, and the picture."""
    folder, image = made
    shutil.copytree(folder, tmp_path / "a project")
    return tmp_path / "a project", image


def reads_files_of(found, folder):
    """Whether all sockets read existing files in a folder."""
    return bool(found["sockets"]) and all(
        there and path.startswith(str(folder)) for path, there in found["sockets"].values()
    )


def test_moved_folder(project):
    folder, image = project
    found = life.run(life.check, path=folder / "scene.blend")
    assert found["states"] == {"grating": "READY"}
    assert reads_files_of(found, folder)
    assert np.allclose(found["picture"], image, atol=1e-4)


def test_save_as_another_folder_renders_without_the_addon(project, tmp_path):
    """The sockets in the file are right for its new folder, those in the old one stay right for theirs."""
    folder, image = project
    there = tmp_path / "elsewhere" / "deep"
    there.mkdir(parents=True)
    saved = life.run(life.save_elsewhere, path=folder / "scene.blend", target=there / "new.blend")
    assert reads_files_of(saved, folder)
    assert saved["scan"] == "//../../a project/diffraction/sinusoid.gsf"
    found = life.run(life.render_file, addon=False, path=there / "new.blend")
    assert reads_files_of(found, folder)
    assert np.allclose(found["picture"], image, atol=1e-4)


@pytest.mark.slow
def test_saving_a_copy_leaves_this_file_right(project, tmp_path):
    folder, image = project
    there = tmp_path / "elsewhere"
    there.mkdir()
    saved = life.run(life.save_elsewhere, path=folder / "scene.blend", target=there / "copy.blend", copy=True)
    assert reads_files_of(saved, folder)
    assert saved["scan"] == "//diffraction/sinusoid.gsf"
    found = life.run(life.render_file, addon=False, path=there / "copy.blend")
    assert np.allclose(found["picture"], image, atol=1e-4)


def test_append_into_a_file_in_another_folder(project, tmp_path):
    folder, image = project
    there = tmp_path / "other"
    there.mkdir()
    found = life.run(life.append_to, path=folder / "scene.blend", target=there / "mine.blend")
    assert found["states"] == {"grating": "READY"}
    assert np.allclose(found["picture"], image, atol=1e-4)
    again = life.run(life.render_file, addon=False, path=there / "mine.blend")
    assert all(exists for _, exists in again["sockets"].values())
    assert np.allclose(again["picture"], image, atol=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_link_into_a_file_in_another_folder(project, tmp_path, implementation):
    """OSL needs the add-on to find the table of a linked material, Nodes do not."""
    folder, image = project
    if implementation == "NODES":
        image = np.array(life.run(life.make_project, path=folder / "scene.blend", implementation="NODES"))
    there = tmp_path / "other"
    there.mkdir()
    found = life.run(life.link_to, path=folder / "scene.blend", target=there / "mine.blend")
    assert found["states"] == {"grating": "READY"}
    assert np.allclose(found["picture"], image, atol=1e-4)
    again = life.run(life.render_file, addon=implementation == "OSL", path=there / "mine.blend")
    assert np.allclose(again["picture"], image, atol=1e-4)


@pytest.mark.slow
def test_linked_osl_material_renders_without_the_addon_once_collected(project, tmp_path):
    """Cycles looks for its table beside the open file: nothing is there at first, then a copy is."""
    folder, image = project
    there = tmp_path / "other"
    there.mkdir()
    found = life.run(life.link_and_collect, path=folder / "scene.blend", target=there / "mine.blend")
    assert found["outcome"] == ["FINISHED"] and found["again"] == ["FINISHED"]
    assert "tables of linked materials" in found["before"] and "tables of linked materials" not in found["after"]
    assert {path.name for path in (there / "diffraction").iterdir()} == {"sinusoid.exr", "sinusoid.importance.exr"}
    plain = life.run(life.render_file, addon=False, path=there / "mine.blend")
    assert np.allclose(plain["picture"], image, atol=1e-4)
    for copy in (there / "diffraction").iterdir():
        copy.unlink()
    bare = life.run(life.render_file, addon=False, path=there / "mine.blend")
    assert np.max(bare["picture"]) < 1e-3 * image.max()  # no table, no light
    stale, original = there / "diffraction" / "sinusoid.exr", folder / "diffraction" / "sinusoid.exr"
    stale.write_bytes(b"before the library was baked anew")
    os.utime(stale, (0, original.stat().st_mtime - 60.0))
    assert life.run(life.collect_again, path=there / "mine.blend") == {"outcome": ["FINISHED"]}
    assert stale.read_bytes() == original.read_bytes()
    stale.write_bytes(b"a table of this file")
    stale.with_suffix(".json").write_text("{}")
    assert life.run(life.collect_again, path=there / "mine.blend") == {"outcome": ["FINISHED"]}
    assert stale.read_bytes() == b"a table of this file"


@pytest.mark.slow
def test_copy_and_paste_between_files(project, tmp_path):
    folder, _ = project
    found = life.run(life.paste_to, path=folder / "scene.blend", target=tmp_path / "mine.blend")
    assert found["states"] == {"grating": "READY"}
    assert all(exists for _, exists in found["sockets"].values())


@pytest.mark.slow
@pytest.mark.parametrize("implementation", ["OSL", "NODES"])
def test_packed_file_alone_renders_elsewhere(project, tmp_path, implementation):
    """Nothing but the .blend goes to another folder with another user."""
    folder, image = project
    if implementation == "NODES":
        image = np.array(life.run(life.make_project, path=folder / "scene.blend", implementation="NODES"))
    packed = life.run(life.pack, path=folder / "scene.blend")
    assert packed["sinusoid"]
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.move(folder / "scene.blend", alone / "scene.blend")
    shutil.rmtree(folder)
    found = life.run(life.check, user=tmp_path / "stranger", path=alone / "scene.blend")
    assert found["states"] == {"grating": "READY"}
    assert np.allclose(found["picture"], image, atol=1e-4)


def test_missing_table_is_baked_again_from_the_stored_scan(project):
    folder, image = project
    for path in (folder / "diffraction").glob("sinusoid*.*"):
        if path.suffix != ".gsf":
            path.unlink()
    found = life.run(life.rebake, path=folder / "scene.blend")
    assert found["before"] == {"grating": "MISSING"}
    assert found["outcome"] == ["FINISHED"]
    assert found["after"] == {"grating": "READY"}
    assert np.allclose(found["picture"], image, atol=1e-4)


@pytest.mark.slow
def test_table_of_another_release_is_recognised_and_baked_again(project):
    folder, image = project
    sidecar = folder / "diffraction" / "sinusoid.json"
    text = sidecar.read_text()
    assert '"format_version": 2' in text
    sidecar.write_text(text.replace('"format_version": 2', '"format_version": 0'))
    found = life.run(life.rebake, path=folder / "scene.blend")
    assert (found["before"], found["after"]) == ({"grating": "OLD"}, {"grating": "READY"})
    assert np.allclose(found["picture"], image, atol=1e-4)


@pytest.mark.slow
def test_lost_scan_is_told_in_a_sentence(project):
    folder, _ = project
    shutil.rmtree(folder / "diffraction")
    found = life.run(life.rebake, path=folder / "scene.blend", forget_origin=True)
    assert found["after"] == {"grating": "MISSING"}
    assert "sinusoid.gsf" in found["outcome"] and "import it again" in found["outcome"]


def test_undo_and_redo(project):
    folder, _ = project
    found = life.run(life.undo, path=folder / "scene.blend")
    assert found["changed"] and found["back"]
    before, undone, redone = found["materials"]
    assert undone == before - 1 and redone == before
    assert set(found["states"].values()) == {"READY"}
    assert reads_files_of(found, folder)
    assert np.max(found["picture"]) > 0.01


@pytest.mark.slow
def test_file_that_was_not_saved_collects_what_it_needs(tmp_path):
    folder = tmp_path / "saved"
    folder.mkdir()
    found = life.run(life.collect, user=tmp_path / "user", path="", target=folder / "scene.blend")
    assert not found["poll"]
    assert not any(path.startswith(str(folder)) for path, _ in found["outside"].values())
    assert all(exists for _, exists in found["outside"].values())
    assert found["outcome"] == ["FINISHED"]
    assert reads_files_of({"sockets": found["inside"]}, folder)
    assert (found["table"], found["scan"]) == ("//diffraction/sinusoid.exr", "//diffraction/sinusoid.gsf")
    assert set(found["states"].values()) == {"READY"}
