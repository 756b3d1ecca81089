# SPDX-License-Identifier: GPL-3.0-or-later
"""Pages outside the guide: their Python runs, their links lead somewhere, the table of formats is whole."""

import re
import subprocess
import sys

import pytest

from precompute.readers.formats import FORMATS
from tests.support.blender import extension

ROOT = extension.ROOT
PAGES = (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")))
SNIPPETS = {
    page: re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    for page in PAGES
    if "```python" in page.read_text(encoding="utf-8")
}

#: What the snippets of these pages take for granted: a scan, its table, a selected object, a lamp, a camera.
READY = """
import os, sys
sys.path.insert(0, {root!r})
import bpy
from tests.support.blender import extension, scenes
extension.load().register()
from precompute.scan.gsf import write_gsf
from precompute.presets import make_preset
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"
bpy.ops.wm.save_as_mainfile(filepath="page.blend")
write_gsf(make_preset("sinusoid", 30e-6, 384, period_um=1.5), "skin.gsf")
bpy.ops.diffraction.import_scan(filepath="skin.gsf")
bpy.ops.diffraction.bake(detail=0.25)
ball = scenes.add_sphere(segments=32, rings=16)
scenes.add_sun((0.3, 0.2, 1.0))
scenes.add_camera()
bpy.context.view_layer.update()
ball.select_set(True)
bpy.context.view_layer.objects.active = ball
bpy.ops.diffraction.apply_material()
{code}
print("SHOWN", sorted(str(p) for p in __import__("pathlib").Path().rglob("*.png")))
print("MATERIAL", any("diffraction_table" in tree for tree in bpy.data.node_groups))
sys.stdout.flush()
os._exit(0)
"""


SLOW = {"viewport.md"}  # pictures of the viewport on a software renderer


@pytest.mark.parametrize(
    "page",
    [pytest.param(page, marks=pytest.mark.slow) if page.name in SLOW else page for page in SNIPPETS],
    ids=lambda page: page.name,
)
def test_snippets_run(page, tmp_path):
    code = "\n".join(SNIPPETS[page]).replace("range(1, 101)", "range(1, 3)")  # a turntable of two frames
    done = subprocess.run(
        [sys.executable, "-c", READY.format(root=str(ROOT), code=code)],
        cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stdout + done.stderr
    assert "MATERIAL True" in done.stdout
    for name in re.findall(r'filepath=f?"//([^"{]+\.png)"', code):
        assert (tmp_path / name).is_file()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_are_there(page):
    targets = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    assert [target for target in targets if "://" not in target and not (page.parent / target).exists()] == []


def test_every_format_stands_in_the_table():
    """Each extension that a reader claims is in one row, with who reads it and what is kept."""
    text = (ROOT / "docs" / "formats.md").read_text(encoding="utf-8")
    rows = [line for line in text.splitlines() if line.startswith("|") and "`." in line]
    assert all(len([cell for cell in row.strip("|").split("|") if cell.strip()]) == 4 for row in rows)
    listed = set(re.findall(r"`(\.\w+)`", " ".join(rows)))
    numbers = {f".{n:03d}" for n in range(1000)}  # Nanoscope counts: `.000` to `.999`
    claimed = {extension for each in FORMATS for extension in each.extensions}
    assert claimed - numbers <= listed


@pytest.mark.parametrize("picture", sorted((ROOT / "docs" / "pictures").iterdir()), ids=lambda path: path.name)
def test_pictures_are_light_and_hold_nothing_of_the_computer_that_made_them(picture):
    content = picture.read_bytes()
    assert len(content) < 1_500_000
    assert b"Blender:File" not in content and b"Blender:Date" not in content  # a path, a name
