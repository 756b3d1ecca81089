# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension into dist/: `build_extension.py [--platform current|all|NAME] [--python current|all|VERSION]`.

One zip a platform and Python of Blender, each with that Python's wheels alone and with the range of Blenders that have
it, of which together no version from the oldest on is left out. Fetches the wheels, checks the manifest, then leaves
building and validating to Blender's own tool; the zips are built from a copy in build/.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path


from tools.build import manual
from tools.build.blender_files import extension_tool
from tools.build.check_manifest import load_manifest
from tools.build.check_manifest import main as check_manifest
from tools.build.fetch_wheels import (
    ROOT,
    WHEELS,
    bundled_name,
    chosen_platforms,
    chosen_pythons,
    fetch,
    pins_by_python,
)
from tools.build.requirements import BLENDERS

DIST = ROOT / "dist"
BUILD = ROOT / "build"


def stage(folder, platforms, python, wheels, version=None):
    """Copy what goes into the zips to a folder, with a manifest for this Python's Blenders and wheels only.

    Parameters
    ----------
    folder : pathlib.Path
        An empty one.
    platforms, wheels : list of str
    python : str
        A key of `BLENDERS`.
    version : str
        In place of the manifest's; for tests of updates.
    """
    manifest, _ = load_manifest()
    excluded = manifest["build"]["paths_exclude_pattern"]
    for entry in ROOT.iterdir():
        if entry.name.startswith(".") or entry.name == "blender_manifest.toml":
            continue
        if f"/{entry.name}/" in excluded or f"/{entry.name}" in excluded:
            continue
        if entry.is_dir():
            shutil.copytree(entry, folder / entry.name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(entry, folder)
    manual.write(folder / "manual")
    (folder / "wheels").mkdir()
    pins = pins_by_python()
    bundled = {wheel: bundled_name(wheel, pins) for wheel in wheels}
    for wheel, name in bundled.items():
        link_or_copy(WHEELS / wheel, folder / "wheels" / name)
    text = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    text = replace_list(text, "platforms", platforms)
    text = replace_list(text, "wheels", [f"./wheels/{name}" for name in bundled.values()])
    first, too_new = BLENDERS[python]
    versions = f'blender_version_min = "{first}"\n' + (f'blender_version_max = "{too_new}"\n' if too_new else "")
    text = re.sub(r"^blender_version_min = .*\n", versions, text, flags=re.MULTILINE)
    if version is not None:
        text = re.sub(r'^version = ".*"', f'version = "{version}"', text, flags=re.MULTILINE)
    (folder / "blender_manifest.toml").write_text(text, encoding="utf-8")


def link_or_copy(source, target):
    """A hard link where the file system has them: wheels are large."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


def replace_list(text, key, values):
    """The TOML text with the list `key` holding other strings."""
    body = "".join(f'    "{value}",\n' for value in values)
    changed, count = re.subn(rf"^{key} = \[.*?\]$", f"{key} = [\n{body}]", text, flags=re.MULTILINE | re.DOTALL)
    if count != 1:
        sys.exit(f"blender_manifest.toml must hold one list named {key}.")
    return changed


def blender_ext(*arguments):
    """Run Blender's `blender_ext.py`; stop where it fails."""
    done = subprocess.run([sys.executable, str(extension_tool()), *arguments], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"Blender's extension tool failed at '{arguments[0]}':\n{done.stdout}{done.stderr}")


def zip_name(manifest, platform, python):
    """A zip's file name, which says what people know of theirs: version, Blender's first, platform.

    >>> zip_name({"id": "diffraction_shader", "version": "0.1.0"}, "linux-x64", "3.13")
    'diffraction_shader-0.1.0-blender_5.1-linux_x64.zip'
    """
    first = BLENDERS[python][0].rpartition(".")[0]
    return f"{manifest['id']}-{manifest['version']}-blender_{first}-{platform.replace('-', '_')}.zip"


def build(platforms, pythons, folder=DIST, bundle=True, version=None):
    """Build and validate the zips of some platforms and Pythons.

    Parameters
    ----------
    platforms, pythons : list of str
        Blender's names, and versions such as ``"3.13"``.
    folder : pathlib.Path
        Where the zips go.
    bundle : bool
        Whether the wheels go in; for tests that need none.
    version : str
        In place of the manifest's; for tests of updates.

    Returns
    -------
    list of pathlib.Path
        The zips, in the order of `pythons`, those of one in the order of `platforms`.
    """
    manifest, _ = load_manifest()
    manifest["version"] = version or manifest["version"]
    folder.mkdir(parents=True, exist_ok=True)
    BUILD.mkdir(exist_ok=True)
    zips = []
    for python in pythons:
        with (
            tempfile.TemporaryDirectory(dir=BUILD, prefix="extension-") as source,
            tempfile.TemporaryDirectory(dir=folder) as built,
        ):
            stage(Path(source), platforms, python, fetch(platforms, [python]) if bundle else [], version)
            blender_ext("validate", source)
            blender_ext("build", "--split-platforms", "--source-dir", source, "--output-dir", built)
            for platform in platforms:
                path = Path(built, f"{manifest['id']}-{manifest['version']}-{platform.replace('-', '_')}.zip")
                blender_ext("validate", str(path))
                zips.append(path.replace(folder / zip_name(manifest, platform, python)))
    return zips


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", default="current", help="current, all, or one of Blender's platform names")
    parser.add_argument("--python", default="all", help="current, all, or one of Blender's Pythons")
    arguments = parser.parse_args()
    if check_manifest():
        sys.exit(1)
    for path in build(chosen_platforms(arguments.platform), chosen_pythons(arguments.python)):
        print(f"{path.relative_to(ROOT)}  {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
