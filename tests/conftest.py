# SPDX-License-Identifier: GPL-3.0-or-later
"""What all tests share: where scans and pictures are, and a Blender that starts empty.

Blender's user folder is decided when `bpy` is first imported, so it is set here, before any test module is.
"""

import atexit
import os
import shutil
import sys
import tempfile
from pathlib import Path

import pytest

from tests.support.smoke import is_smoke

ROOT = Path(__file__).resolve().parent.parent

_user_resources = tempfile.mkdtemp(prefix="diffraction_blender_user_")
os.environ["BLENDER_USER_RESOURCES"] = _user_resources
atexit.register(shutil.rmtree, _user_resources, ignore_errors=True)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """What is thorough is slow too; the smoke tests are those of tests/support/smoke.py."""
    for item in items:
        if is_smoke(item.nodeid.partition("[")[0]):
            item.add_marker(pytest.mark.smoke)
        if item.get_closest_marker("thorough"):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def root_dir():
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def out_dir():
    """`out/`, where pictures for people are written."""
    folder = ROOT / "out"
    folder.mkdir(exist_ok=True)
    return folder


@pytest.fixture(scope="session")
def scan_dir():
    """The folder of real scans: DIFFRACTION_SCAN_DIR, by default ../shared/data beside the checkout."""
    folder = Path(os.environ.get("DIFFRACTION_SCAN_DIR", ROOT.parent / "shared" / "data"))
    if not folder.is_dir():
        pytest.skip(f"no real scans in {folder}: set DIFFRACTION_SCAN_DIR to a folder that holds them")
    return folder


@pytest.fixture(scope="session")
def bpy_module():
    """Blender as a module, with oslquery on the path: without it script nodes get no sockets.

    Only tests do this; an extension must never edit `sys.path`.
    """
    import bpy

    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    packages = os.path.join(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages")
    if packages not in sys.path:
        sys.path.append(packages)
    return bpy


@pytest.fixture
def empty_blender(bpy_module):
    """`bpy` with factory settings and an empty scene, for each test anew."""
    bpy_module.ops.wm.read_factory_settings(use_empty=True)
    return bpy_module
