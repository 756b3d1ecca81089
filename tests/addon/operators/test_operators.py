# SPDX-License-Identifier: GPL-3.0-or-later
"""From a scan to a material by the operators that scripts call."""

import re
import subprocess
import sys

import bpy
import numpy as np
import pytest

from tests.support import odd_scans
from tests.support.blender import extension, scenes

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture
def saved(blender, tmp_path):
    """A saved .blend in a folder of its own."""
    folder = tmp_path / "project"
    folder.mkdir()
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "scene.blend"))
    return folder


@pytest.fixture
def scan(tmp_path):
    """A small grating as 16-bit picture: no units, heights that 32-bit floats round."""
    from PIL import Image

    x = (np.arange(96) + 0.5) / 96
    heights = 0.5 + 0.5 * np.sin(2 * np.pi * 5 * x)[None] * np.cos(2 * np.pi * 3 * x)[:, None]
    path = tmp_path / "grating.png"
    Image.fromarray((heights * 65535).astype(np.uint16)).save(path)
    return path


def import_and_bake(scan):
    bpy.ops.diffraction.import_scan(filepath=str(scan), size_um=(8.1, 8.1), height_nm=118.69)
    assert bpy.ops.diffraction.bake(sigma_s_um=0.7) == {"FINISHED"}


def test_operator_python_and_command_line_make_the_same_table(saved, scan, tmp_path):
    from precompute.bake.baking import bake_file
    from precompute.parameters import BakeParameters

    import_and_bake(scan)
    bake_file(
        scan, tmp_path / "python", BakeParameters(sigma_s_m=0.7 * 1e-6, level="poly2"),
        size_m=(8.1 * 1e-6, 8.1 * 1e-6), height_m=118.69 * 1e-9,
    )  # fmt: skip
    options = ["--size-um", "8.1", "8.1", "--height-nm", "118.69", "--sigma-s-um", "0.7", "--level", "poly2"]
    subprocess.run(
        [sys.executable, "-m", "precompute", "bake", str(scan), "--out", str(tmp_path / "cli"), *options],
        check=True, cwd=extension.ROOT, capture_output=True,
    )  # fmt: skip
    for name in ("grating.exr", "grating.json"):
        by_operator = (saved / "diffraction" / name).read_bytes()
        assert by_operator == (tmp_path / "python" / name).read_bytes()
        assert by_operator == (tmp_path / "cli" / name).read_bytes()


def test_stored_scan_takes_the_place_of_a_lost_original(saved, scan):
    bpy.ops.diffraction.import_scan(filepath=str(scan), size_um=(8.1, 8.1), height_nm=118.69)
    scan.unlink()
    assert bpy.context.scene.diffraction.scan_path == "//diffraction/grating.gsf"
    assert bpy.ops.diffraction.bake(sigma_s_um=0.7) == {"FINISHED"}
    assert (saved / "diffraction" / "grating.exr").is_file()


def test_chain_ends_in_a_picture(saved, scan):
    import_and_bake(scan)
    plane = scenes.add_plane()
    scenes.add_sun((0.1, 0.2, 1.0))
    scenes.add_camera()
    bpy.context.view_layer.update()
    plane.select_set(True)
    assert bpy.ops.diffraction.apply_material(fresnel="NONE") == {"FINISHED"}
    material = plane.active_material
    assert material.cycles.use_bump_map_correction is False
    image = bpy.data.images["grating"]
    assert image.filepath == "//diffraction/grating.exr"
    assert image.use_fake_user
    assert image.colorspace_settings.name == "Non-Color"
    assert scenes.render(size=16).max() > 0.0


def test_shader_that_was_there_becomes_the_pigment(saved, scan):
    import_and_bake(scan)
    plane = scenes.add_plane()
    painted = bpy.data.materials.new("paint")
    extension.give_nodes(painted)
    before = painted.node_tree.nodes["Material Output"].inputs["Surface"].links[0].from_node.name
    plane.data.materials.append(painted)
    bpy.context.view_layer.update()
    plane.select_set(True)
    bpy.ops.diffraction.apply_material()
    made = plane.active_material
    assert made != painted
    assert painted.node_tree.nodes.get("Diffraction") is None
    node = made.node_tree.nodes["Diffraction"]
    assert node.inputs["Base"].links[0].from_node.name == before
    count = len(made.node_tree.nodes)
    bpy.ops.diffraction.apply_material(ior=1.4)  # again: the same material, nothing piles up
    assert plane.active_material == made
    assert len(made.node_tree.nodes) == count
    assert made.node_tree.nodes["Diffraction"].inputs["IOR"].default_value == pytest.approx(1.4)


@pytest.mark.parametrize(
    ("content", "size_um", "height_nm", "words"),
    [
        (None, (1, 1), 100, "no file"),
        (b"", (1, 1), 100, "empty"),
        (b"nonsense \x00\x01\x02", (1, 1), 100, "format is not known"),
        ("picture", (0, 0), 100, "size"),
        ("picture", (8, 8), 0, "height"),
        ("picture", (8, -1), 100, "size"),
    ],
)
def test_bad_scans_give_one_sentence_and_leave_nothing(saved, scan, tmp_path, content, size_um, height_nm, words):
    path = scan
    if content != "picture":
        path = tmp_path / "bad.xyz"
        if content is not None:
            path.write_bytes(content)
    with pytest.raises(RuntimeError, match=words) as caught:
        bpy.ops.diffraction.import_scan(filepath=str(path), size_um=size_um, height_nm=height_nm)
    assert "Traceback" not in str(caught.value)
    assert bpy.context.scene.diffraction.scan_path == ""
    assert not (saved / "diffraction").exists() or not list((saved / "diffraction").iterdir())


def test_sizes_without_a_unit_are_asked_about_in_the_windows_words(saved, tmp_path):
    path = tmp_path / "wide.ibw"
    path.write_bytes(odd_scans.igor_without_units(1.0))
    with pytest.raises(RuntimeError, match="4 m x 3 m") as caught:
        bpy.ops.diffraction.import_scan(filepath=str(path))
    assert "Size (um)" in str(caught.value) and "Trust Units" in str(caught.value) and "--" not in str(caught.value)
    assert bpy.ops.diffraction.import_scan(filepath=str(path), trust_units=True) == {"FINISHED"}
    state = bpy.context.scene.diffraction
    assert "metres were assumed" in state.scan_info
    # What is stored is not asked about again.
    assert bpy.ops.diffraction.use_stored_scan(name="wide") == {"FINISHED"}
    bpy.ops.diffraction.import_scan(filepath=str(path), size_um=(8, 6))
    assert "8 x 6 um" in state.scan_info


def test_bake_over_the_limit_and_table_of_another_version(saved, scan):
    bpy.ops.diffraction.import_scan(filepath=str(scan), size_um=(8.1, 8.1), height_nm=118.69)
    with pytest.raises(RuntimeError, match="limit"):
        bpy.ops.diffraction.bake(sigma_s_um=0.7, limit_mb=1)
    assert not (saved / "diffraction" / "grating.exr").exists()
    bpy.ops.diffraction.bake(sigma_s_um=0.7)
    sidecar = saved / "diffraction" / "grating.json"
    sidecar.write_text(re.sub(r'"format_version": \d+', '"format_version": 99', sidecar.read_text()))
    plane = scenes.add_plane()
    bpy.context.view_layer.update()
    plane.select_set(True)
    with pytest.raises(RuntimeError, match="version 99"):
        bpy.ops.diffraction.apply_material()
    assert plane.active_material is None


def test_grey_buttons_say_why():
    assert not bpy.ops.diffraction.bake.poll()
    assert not bpy.ops.diffraction.apply_material.poll()
    with pytest.raises(RuntimeError, match="Import a scan"):
        bpy.ops.diffraction.bake()


def test_thread_engine_stops_and_writes_nothing(saved, scan):
    from diffraction_shader.addon.tables.bake_job import BakeJob
    from diffraction_shader.precompute.errors import Cancelled
    from diffraction_shader.precompute.parameters import BakeParameters

    reading = {"size_m": (8.1e-6, 8.1e-6), "height_m": 1e-7}
    job = BakeJob(scan, saved / "out", "x", BakeParameters(sigma_s_m=7e-7), reading)
    job.watch = lambda fraction: job.cancel() if fraction > 0.2 else None
    job.start()
    with pytest.raises(Cancelled):
        job.result()
    assert not list((saved / "out").glob("*"))


def test_preset_and_unsaved_file():
    assert bpy.ops.diffraction.make_preset(preset="sinusoid", size_um=10, pixels=128) == {"FINISHED"}
    from pathlib import Path

    stored = Path(bpy.context.scene.diffraction.scan_path)
    assert stored.is_absolute()
    assert stored.is_file()


def test_panel_draws_from_scan_to_material(saved, scan):
    """The panels in a real layout: the buttons stand in the order of the work."""
    from diffraction_shader.addon import panels

    import_and_bake(scan)
    plane = scenes.add_plane()
    bpy.context.view_layer.update()
    plane.select_set(True)
    bpy.context.view_layer.objects.active = plane
    bpy.ops.diffraction.apply_material()
    shown = []
    for cls in panels.CLASSES:
        if not hasattr(cls, "draw"):  # a handler of dropped files
            continue
        if hasattr(cls, "poll") and not cls.poll(bpy.context):
            continue
        stand_in = type("Panel", (), {"layout": bpy.context.window_manager.popmenu_begin__internal("test").layout})
        cls.draw(stand_in, bpy.context)
        shown.append(str(stand_in.layout.introspect()))
    text = " ".join(shown)
    places = [
        text.index(name) for name in ("diffraction.import_scan", "diffraction.bake", "diffraction.apply_material")
    ]
    assert places == sorted(places)
    assert "IOR" in text
