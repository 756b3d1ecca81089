# SPDX-License-Identifier: GPL-3.0-or-later
"""The built zip in an empty Blender: it installs, enables, disables, loads nothing heavy, and brings its libraries."""

import json
import os
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest

from tools.build.build_extension import zip_name
from tools.build.check_manifest import fits, load_manifest, version
from tools.build.requirements import BLENDERS

ROOT = Path(__file__).resolve().parents[2]
MODULE = "bl_ext.user_default.diffraction_shader"
BUNDLED = ("scipy", "colour", "OpenEXR", "matplotlib", "tifffile", "threadpoolctl")

INSTALL = """
import sys, bpy
bpy.ops.extensions.package_install_files(
    filepath=sys.argv[1], repo="user_default", enable_on_install=True, overwrite=True
)
"""

IN_BLENDER = f"""
import json, os, sys
import bpy

def ours():
    return sorted(name for name in dir(bpy.types) if name.startswith("DIFFRACTION_"))

before = ours()
{INSTALL}
found = {{"before": before, "enabled": {MODULE!r} in bpy.context.preferences.addons, "classes": ours()}}
found["heavy"] = sorted(set({BUNDLED!r}) & set(sys.modules))
found["path"] = os.path.dirname(sys.modules[{MODULE!r}].__file__) if {MODULE!r} in sys.modules else None
names = ("import_scan", "bake", "apply_material")
found["operators"] = [hasattr(bpy.types, "DIFFRACTION_OT_" + name) for name in names]
import addon_utils
addon_utils.disable({MODULE!r})
found["after_disable"] = ours()
addon_utils.enable({MODULE!r})
found["after_enable"] = ours()
print("\\nFOUND" + json.dumps(found), flush=True)
os._exit(0)
"""

OUTSIDE_BLENDER = """
import sys
sys.path[:] = [path for path in sys.path if "site-packages" not in path] + sys.argv[1:]
import colour, matplotlib.pyplot, OpenEXR, scipy.fft, scipy.ndimage, scipy.signal, threadpoolctl, tifffile
import dateutil, PIL.Image
for module in (colour, matplotlib, OpenEXR, scipy, threadpoolctl, tifffile):
    assert module.__file__.startswith(sys.argv[1]), module.__file__
from diffraction_shader.precompute import cli
for line in (
    "preset sinusoid --size-um 8 --pixels 96 --out s.gsf",
    "bake s.gsf --detail 0.1 --sigma-s-um 0.5 --out out",
    "map out/s.exr --theta-i 30 --phi-i 0 --size 32 --out map.png",
    "reflectance s.gsf --theta-i 20 --from 0 --to 15 --step 5 --out plot.png",
    "reflectance s.gsf --theta-i 20 --from 0 --to 15 --step 5 --out plot.pdf",
):
    assert not cli.main(line.split()), line
from pathlib import Path
from diffraction_shader.precompute.readers import read_scan
from diffraction_shader.precompute.scan import levelling_picture
scan = read_scan(Path("s.gsf"))
levelling_picture.levelling_picture(scan, scan)
"""


def script(name, *arguments):
    """Run a script of tools/build."""
    command = [sys.executable, ROOT / "tools" / "build" / name, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


@pytest.fixture(scope="session")
def extension_zip():
    """The extension for this platform and Python, built by the project's own script."""
    fetched = script("fetch_wheels.py", "--python", "current")
    if fetched.returncode and "CI" not in os.environ and "Connection" in fetched.stderr:
        pytest.skip(f"the wheels cannot be downloaded: {fetched.stderr.strip().splitlines()[-1]}")
    assert fetched.returncode == 0, fetched.stderr
    built = script("build_extension.py", "--python", "current")
    assert built.returncode == 0, built.stderr
    return ROOT / built.stdout.split("  ")[0]


def in_blender(script, extension_zip, user):
    """Run a script, which gets the zip's path, in a Blender with this user folder."""
    return subprocess.run(
        [sys.executable, "-c", script, str(extension_zip)],
        cwd=user,
        env={**os.environ, "BLENDER_USER_RESOURCES": str(user)},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.fixture(scope="session")
def installed(extension_zip, tmp_path_factory):
    """What a Blender with an empty user folder says after installing the zip, and that folder."""
    user = tmp_path_factory.mktemp("user")
    done = in_blender(IN_BLENDER, extension_zip, user)
    lines = [line for line in done.stdout.splitlines() if line.startswith("FOUND")]
    assert lines, done.stdout + done.stderr
    return json.loads(lines[0].removeprefix("FOUND")), user


def test_it_is_enabled_after_install(installed):
    found, user = installed
    assert found["enabled"]
    assert found["path"].startswith(str(user))
    assert found["before"] == []
    assert all(found["operators"])


def test_blender_leaves_without_an_error(extension_zip, tmp_path):
    done = in_blender(f"{INSTALL}assert {MODULE!r} in bpy.context.preferences.addons", extension_zip, tmp_path)
    assert done.returncode == 0, done.stderr
    assert "Traceback" not in done.stdout + done.stderr


def test_registering_loads_nothing_heavy(installed):
    found, _ = installed
    assert found["heavy"] == []


def test_it_can_be_disabled_and_enabled_again(installed):
    found, _ = installed
    assert found["after_disable"] == []
    assert found["after_enable"] == found["classes"] != []


def test_the_bundled_libraries_work_with_blenders_numpy_alone(installed, tmp_path):
    """Nothing but numpy can be found besides, as in a Blender that a user installs; all that needs them runs."""
    _, user = installed
    packages = next((user / "extensions" / ".local").glob("**/site-packages"))
    numpy = Path(np.__file__).parent
    for folder in [numpy, *numpy.parent.glob("numpy.libs")]:
        (tmp_path / folder.name).symlink_to(folder)
    done = subprocess.run(
        [
            sys.executable,
            "-I",
            "-c",
            OUTSIDE_BLENDER,
            str(packages),
            str(tmp_path),
            str(user / "extensions/user_default"),
        ],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert not list(packages.glob("numpy"))


def test_the_zip_is_small_and_of_one_python(extension_zip):
    """The wheels of the other Pythons alone would nearly double it."""
    with zipfile.ZipFile(extension_zip) as archive:
        names = [name for name in archive.namelist() if name.endswith(".whl")]
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    python = "{}.{}".format(*sys.version_info)
    assert all(fits(name.rpartition("/")[2], python) for name in names)
    assert sorted(manifest["wheels"]) == sorted(f"./{name}" for name in names)
    assert extension_zip.stat().st_size < 75e6
    first, too_new = BLENDERS[python]
    assert (manifest["blender_version_min"], manifest.get("blender_version_max")) == (first, too_new)


def test_every_blender_finds_a_zip():
    """The ranges of the zips meet: from the oldest Blender of the manifest on, without an end."""
    ranges = sorted(BLENDERS.values(), key=lambda pair: version(pair[0]))
    manifest, _ = load_manifest()
    assert ranges[0][0] == manifest["blender_version_min"]
    assert [too_new for _, too_new in ranges] == [*(first for first, _ in ranges[1:]), None]
    names = {zip_name(manifest, "linux-x64", python) for python in BLENDERS}
    assert len(names) == len(BLENDERS)


def test_only_what_runs_is_in_the_zip(extension_zip):
    with zipfile.ZipFile(extension_zip) as archive:
        names = archive.namelist()
    top = {name.partition("/")[0] for name in names}
    assert top == {
        "blender_manifest.toml",
        "__init__.py",
        "LICENSE",
        "addon",
        "precompute",
        "shaders",
        "wheels",
        "manual",
    }
    assert not [name for name in names if "__pycache__" in name or name.endswith((".pyc", ".tmp"))]
    sources = {str(path.relative_to(ROOT)) for path in (ROOT / "precompute").rglob("*.py")}
    assert sources <= set(names)
    assert "precompute/light/colour_data.json" in names
