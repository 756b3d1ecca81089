# SPDX-License-Identifier: GPL-3.0-or-later
"""A release as users get it: from an address, into a Blender that knows nothing of it yet, and then its update.

The server listens on the loopback address alone. Only a profile that is thrown away may go online.
"""

import functools
import http.server
import json
import os
import subprocess
import sys
import threading

import pytest

from tools.build import release
from tools.build.build_extension import blender_ext
from tools.build.fetch_wheels import PLATFORMS, current_platform
from tools.build.requirements import BLENDERS, PYTHONS

PYTHON = "{}.{}".format(*sys.version_info)

#: Adds the address as a remote repository, installs, waits for the newer release, updates. Prints what it found.
IN_BLENDER = """
import json, os, sys, tomllib
from pathlib import Path
import bpy

address, bundled = sys.argv[1], sys.argv[2] == "bundled"
preferences = bpy.context.preferences
preferences.system.use_online_access = True
bpy.ops.preferences.extension_repo_add(name="Diffraction", remote_url=address, type="REMOTE")
index, repository = next(
    (i, each) for i, each in enumerate(preferences.extensions.repos) if each.remote_url == address
)
name = f"bl_ext.{repository.module}.diffraction_shader"

def version():
    manifest = tomllib.loads((Path(repository.directory) / "diffraction_shader" / "blender_manifest.toml").read_text())
    return manifest["version"], manifest["blender_version_min"]

found = {"before": name in preferences.addons}
bpy.ops.extensions.repo_sync(repo_index=index)
bpy.ops.extensions.package_install(repo_index=index, pkg_id="diffraction_shader", enable_on_install=True)
found["enabled"] = name in preferences.addons and hasattr(bpy.types, "DIFFRACTION_OT_bake")
found["installed"] = version()
if bundled:
    (packages,) = (Path(repository.directory).parent / ".local").glob("**/site-packages")
    found["libraries"] = sorted(path.name for path in packages.iterdir())
bpy.context.scene.diffraction.sigma_s_um = 3.5
print("\\nINSTALLED", flush=True)
assert sys.stdin.readline().strip() == "go on"
bpy.ops.extensions.repo_sync(repo_index=index)
bpy.ops.extensions.package_upgrade_all()
found["updated"] = version()
found["still enabled"] = name in preferences.addons and hasattr(bpy.types, "DIFFRACTION_OT_bake")
found["kept"] = bpy.context.scene.diffraction.sigma_s_um
print("\\nFOUND" + json.dumps(found), flush=True)
os._exit(0)
"""


class Handler(http.server.SimpleHTTPRequestHandler):
    """Remembers what was asked for."""

    asked: list

    def log_message(self, form, *arguments):
        self.asked.append(arguments[0])


@pytest.fixture
def served(tmp_path):
    """A folder, its address, and what was asked of its server."""
    folder = tmp_path / "dist"
    folder.mkdir()
    asked = []
    handler = functools.partial(type("Handling", (Handler,), {"asked": asked}), directory=str(folder))
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield folder, f"http://127.0.0.1:{server.server_port}/index.json", asked
    server.shutdown()
    thread.join()
    server.server_close()


def installed_and_updated(served, user, bundle):
    """What a new Blender says after installing a release from an address and updating it to the next."""
    folder, address, asked = served
    release.release(folder, [current_platform()], [PYTHON], bundle=bundle)
    user.mkdir()
    blender = subprocess.Popen(
        [sys.executable, "-c", IN_BLENDER, address, "bundled" if bundle else "alone"],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=user,
        env={**os.environ, "BLENDER_USER_RESOURCES": str(user)},
    )  # fmt: skip
    said = ""
    try:
        for line in blender.stdout:
            said += line
            if line.startswith("INSTALLED"):
                break
        assert "INSTALLED" in said, said
        release.release(folder, [current_platform()], [PYTHON], bundle=False, version="9.0.0")
        rest, _ = blender.communicate("go on\n", timeout=300)
    finally:
        blender.kill()
        blender.wait()
    lines = [line for line in rest.splitlines() if line.startswith("FOUND")]
    assert lines, said + rest
    assert all(" /index.json" in line or ".zip" in line for line in asked), asked
    return json.loads(lines[0].removeprefix("FOUND"))


def check(found):
    first = BLENDERS[PYTHON][0]
    manifest, _ = release.load_manifest()
    assert not found["before"] and found["enabled"] and found["still enabled"]
    assert found["installed"] == [manifest["version"], first]
    assert found["updated"] == ["9.0.0", first]
    assert found["kept"] == 3.5  # a scene that is open loses nothing


def test_it_is_installed_and_updated_from_an_address(served, tmp_path):
    check(installed_and_updated(served, tmp_path / "user", bundle=False))


@pytest.mark.slow
def test_with_its_libraries(served, tmp_path):
    found = installed_and_updated(served, tmp_path / "user", bundle=True)
    check(found)
    assert {"OpenEXR", "PIL", "colour", "matplotlib", "scipy"} <= {name.split(".")[0] for name in found["libraries"]}


@pytest.fixture(scope="module")
def complete(tmp_path_factory):
    """A release of all platforms and Blenders, without the wheels: its zips and its index."""
    folder = tmp_path_factory.mktemp("dist")
    (folder / "diffraction_shader-0.0.1-old.zip").write_bytes(b"of an earlier release")
    zips, index = release.release(folder, list(PLATFORMS), list(PYTHONS), bundle=False)
    return folder, zips, index


def test_a_release_holds_every_platform_and_python(complete):
    folder, zips, index = complete
    assert sorted(path.name for path in folder.glob("*.zip")) == sorted(path.name for path in zips)
    assert len(zips) == len(PLATFORMS) * len(PYTHONS)
    assert {entry["archive_url"] for entry in index["data"]} == {f"./{path.name}" for path in zips}
    assert (folder / "index.html").read_text(encoding="utf-8").count(".zip") >= len(zips)


@pytest.mark.parametrize("platform", PLATFORMS)
@pytest.mark.parametrize("blender", ["4.5.0", "4.5.15", "5.0.0", "5.0.9", "5.1.0", "5.2.3", "6.3.0"])
def test_every_blender_finds_one_zip(complete, platform, blender):
    _, _, index = complete
    (entry,) = release.entries_for(index, platform, blender)
    assert entry["version"] == release.load_manifest()[0]["version"]


def test_an_older_blender_finds_none(complete):
    assert release.entries_for(complete[2], "linux-x64", "4.4.3") == []


def test_a_tool_that_fails_is_told(tmp_path):
    with pytest.raises(SystemExit, match="server-generate"):
        blender_ext("server-generate", "--repo-dir", str(tmp_path / "nowhere"))
