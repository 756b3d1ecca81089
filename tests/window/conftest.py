# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender window with the extension in it, for all tests of a run; they follow each other as a working day does."""

import contextlib
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from tests.window.desk import Desk
from tests.window.drivers import Rig, Simulated

ROOT = Path(__file__).resolve().parents[2]

SKIPPED = "no Blender window: give BLENDER=path of a Blender, or WINDOW_RIG= and WINDOW_FOLDER="


def pytest_collection_modifyitems(items):
    """Minutes each, and only on request."""
    for item in items:
        if Path(item.path).parent == ROOT / "tests" / "window":
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def work():
    """A folder that Blender sees under the same path: WINDOW_WORK, or a new one."""
    given = os.environ.get("WINDOW_WORK") or os.environ.get("WINDOW_FOLDER")
    if given:
        folder = Path(given) / "exchange" if "WINDOW_WORK" not in os.environ else Path(given)
        return Path(tempfile.mkdtemp(prefix="window_", dir=folder))
    return Path(tempfile.mkdtemp(prefix="diffraction_window_"))


@pytest.fixture(scope="session")
def zipped(work):
    """The extension's zip: WINDOW_ZIP, the rig's own build, or that of tools/build."""
    given = os.environ.get("WINDOW_ZIP")
    if given:
        return Path(given)
    rig = os.environ.get("WINDOW_RIG")
    if rig:
        out = work / "extension.zip"
        subprocess.run([sys.executable, str(Path(rig) / "zip314.py"), str(ROOT), str(out)], check=True)
        return out
    build = [sys.executable, str(ROOT / "tools/build/build_extension.py"), "--platform", "linux-x64"]
    subprocess.run(build, check=True)
    told = subprocess.run([os.environ["BLENDER"], "--version"], check=True, capture_output=True, text=True).stdout
    version = _version(re.search(r"Blender (\d+\.\d+)", told))
    zips = {_version(re.search(r"blender_(\d+\.\d+)", path.name)): path for path in ROOT.glob("dist/*linux*.zip")}
    return zips[max(first for first in zips if first <= version)]


def _version(found):
    """Numbers of a release in a name."""
    return tuple(map(int, found.group(1).split(".")))


@pytest.fixture(scope="session")
def desk(work):
    """The window."""
    blender, rig, folder = (os.environ.get(name) for name in ("BLENDER", "WINDOW_RIG", "WINDOW_FOLDER"))
    if blender:
        driver = Simulated(blender, work)
    elif rig and folder:
        driver = Rig(rig, folder)
    else:
        pytest.skip(SKIPPED)
    pictures = ROOT / "out" / "window"
    pictures.mkdir(parents=True, exist_ok=True)
    for old in pictures.glob("failed_*"):
        old.unlink()
    try:
        yield Desk(driver, work, pictures)
    finally:
        driver.quit()


@pytest.fixture(scope="session")
def enabled(desk, zipped):
    """The window with the extension installed from disk, its tab open."""
    options = f"filepath={str(zipped)!r}, repo='user_default', enable_on_install=True"
    desk.run(f"bpy.ops.extensions.package_install_files({options})")
    assert desk.look("[a.module for a in bpy.context.preferences.addons if 'diffraction' in a.module]")
    desk.open_sidebar()
    return desk


@pytest.fixture(autouse=True)
def idle(request):
    """What a failed test left at work ends, so that it fails alone."""
    yield
    if "enabled" in request.fixturenames:
        request.getfixturevalue("enabled").stop()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    """A picture of what the screen showed when a test failed, and why, at once: a whole day takes long."""
    report = yield
    if report.failed and "desk" in item.funcargs:
        item.funcargs["desk"].keep(f"failed_{item.name}.txt", report.longreprtext)
        with contextlib.suppress(AssertionError, subprocess.SubprocessError):  # a window that does not answer
            item.funcargs["desk"].shot(f"failed_{item.name}")
    return report
