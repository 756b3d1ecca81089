# SPDX-License-Identifier: GPL-3.0-or-later
"""The guide's snippets run, its reference is what the properties are, its links lead somewhere."""

import importlib.util
import re
import subprocess
import sys

import bpy
import pytest

from tests.support.blender import extension

GUIDE = extension.ROOT / "docs" / "guide"
SNIPPETS = re.findall(r"```python\n(.*?)```", (GUIDE / "scripting.md").read_text(encoding="utf-8"), re.DOTALL)

ENABLED = """
import os, sys
sys.path.insert(0, {root!r})
if "import bpy" in {code!r}:
    import bpy
    from tests.support.blender import extension
    extension.load().register()
exec(compile({code!r}, "snippet", "exec"))
sys.stdout.flush()
os._exit(0)
"""


def run(code, folder):
    done = subprocess.run(
        [sys.executable, "-c", ENABLED.format(root=str(extension.ROOT), code=code)],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return done.stdout


def names(snippets):
    return [next(line for line in code.splitlines() if "import" not in line and line) for code in snippets]


@pytest.mark.parametrize("code", SNIPPETS[1:], ids=names(SNIPPETS[1:]))
def test_snippet_runs(code, tmp_path):
    run(code, tmp_path)


def test_the_first_snippet_makes_a_picture_with_light_in_it(tmp_path):
    import matplotlib.image

    run(SNIPPETS[0], tmp_path)
    picture = matplotlib.image.imread(tmp_path / "picture.png")[..., :3]
    assert picture.shape == (48, 48, 3)
    assert picture.max() > 0.3
    assert (tmp_path / "diffraction" / "blazed.exr").is_file()


def test_reference_is_what_the_properties_are(blender):
    spec = importlib.util.spec_from_file_location("reference", extension.ROOT / "tools" / "docs" / "reference.py")
    reference = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(reference)
    page = reference.page(bpy)
    assert (GUIDE / "parameters.md").read_text(encoding="utf-8") == page, "run tools/docs/reference.py"


def test_every_property_of_the_scene_is_in_the_reference_or_holds_state(blender):
    state = {
        "rna_type", "name", "scan_path", "source_path", "source_sha256", "reading", "scan_info", "table_path",
        "table_recipe", "imported", "channels", "message", "presets", "map_image", "plot_result", "illuminant_data",
        "stack_colour", "paint",
    }  # fmt: skip
    page = (GUIDE / "parameters.md").read_text(encoding="utf-8")
    known = bpy.context.scene.diffraction.bl_rna.properties
    assert [p.identifier for p in known if p.identifier not in state and f"| `{p.identifier}` |" not in page] == []


@pytest.mark.parametrize("page", sorted(GUIDE.glob("*.md")), ids=lambda page: page.name)
def test_links_and_pictures_are_there(page):
    targets = re.findall(r"\]\(([^)#]+)\)", page.read_text(encoding="utf-8"))
    assert [target for target in targets if "://" not in target and not (page.parent / target).exists()] == []
