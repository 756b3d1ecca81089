# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the extension, one zip a platform, into dist/: `build_extension.py [--platform current|all|NAME]`.

Fetches the wheels, checks the manifest, then leaves building and validating to Blender's own tool. The zips are built
from a copy in build/extension, so that one platform's zip needs only that platform's wheels.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path


from tools.build.blender_files import extension_tool
from tools.build.check_manifest import load_manifest
from tools.build.check_manifest import main as check_manifest
from tools.build.fetch_wheels import ROOT, WHEELS, bundled_name, chosen_platforms, fetch, pins_by_python

DIST = ROOT / "dist"
STAGE = ROOT / "build" / "extension"


def stage(manifest, platforms, wheels):
    """Copy what goes into the zips to build/extension, with a manifest for these platforms and wheels only."""
    shutil.rmtree(STAGE, ignore_errors=True)
    STAGE.mkdir(parents=True)
    excluded = manifest["build"]["paths_exclude_pattern"]
    for entry in ROOT.iterdir():
        if entry.name.startswith(".") or entry.name == "blender_manifest.toml":
            continue
        if f"/{entry.name}/" in excluded or f"/{entry.name}" in excluded:
            continue
        if entry.is_dir():
            shutil.copytree(entry, STAGE / entry.name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy2(entry, STAGE)
    (STAGE / "wheels").mkdir()
    pins = pins_by_python()
    bundled = {wheel: bundled_name(wheel, pins) for wheel in wheels}
    for wheel, name in bundled.items():
        link_or_copy(WHEELS / wheel, STAGE / "wheels" / name)
    text = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    text = replace_list(text, "platforms", platforms)
    text = replace_list(text, "wheels", [f"./wheels/{name}" for name in bundled.values()])
    (STAGE / "blender_manifest.toml").write_text(text, encoding="utf-8")


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


def build(platforms):
    """Build and validate the zips of some platforms.

    Parameters
    ----------
    platforms : list of str
        Blender's names.

    Returns
    -------
    list of pathlib.Path
        The zips, in the order of `platforms`.
    """
    manifest, _ = load_manifest()
    stage(manifest, platforms, fetch(platforms))
    DIST.mkdir(exist_ok=True)
    blender_ext("validate", str(STAGE))
    blender_ext("build", "--split-platforms", "--source-dir", str(STAGE), "--output-dir", str(DIST))
    stem = f"{manifest['id']}-{manifest['version']}"
    zips = [DIST / f"{stem}-{name.replace('-', '_')}.zip" for name in platforms]
    for path in zips:
        blender_ext("validate", str(path))
    shutil.rmtree(STAGE)
    return zips


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", default="current", help="current, all, or one of Blender's platform names")
    arguments = parser.parse_args()
    if check_manifest():
        sys.exit(1)
    for path in build(chosen_platforms(arguments.platform)):
        print(f"{path.relative_to(ROOT)}  {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
