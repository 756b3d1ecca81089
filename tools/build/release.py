# SPDX-License-Identifier: GPL-3.0-or-later
"""All that a release publishes: `release.py [--platform all|current|NAME] [--python all|current|VERSION] [--out DIR]`.

Into dist/ go the zips of all platforms and Blenders, and beside them `index.json` and `index.html`, written by
Blender's own `extension server-generate`. Any web server that hands the folder out as it is makes it a repository: with
the address of `index.json` in *Preferences > Get Extensions > Repositories > Add Remote Repository* users get the zip
for their Blender and platform, and later releases as updates.
"""

import argparse
import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path


from tools.build.build_extension import DIST, blender_ext, build
from tools.build.changelog import read_changelog
from tools.build.check_manifest import load_manifest, version
from tools.build.check_manifest import main as check_manifest
from tools.build.fetch_wheels import chosen_platforms, chosen_pythons


def entries_for(index, platform, blender):
    """The entries of an index that a Blender on a platform may install.

    Parameters
    ----------
    index : dict
        Of `index.json`.
    platform, blender : str
        Blender's name, and a version such as ``"4.5.3"``.
    """
    return [
        entry
        for entry in index["data"]
        if platform in entry["platforms"]
        and version(entry["blender_version_min"]) <= version(blender)
        and ("blender_version_max" not in entry or version(blender) < version(entry["blender_version_max"]))
    ]


def write_index(folder):
    """Have Blender write `index.json` and `index.html` for the zips of a folder.

    Parameters
    ----------
    folder : pathlib.Path

    Returns
    -------
    dict
        The index.
    """
    blender_ext("server-generate", "--html", "--repo-dir", str(folder))
    return json.loads((folder / "index.json").read_text(encoding="utf-8"))


def release(folder, platforms, pythons, **options):
    """Build the zips of a release into a folder, which loses those of others, and their index.

    Parameters
    ----------
    folder : pathlib.Path
    platforms, pythons : list of str
    options
        Of `build`.

    Returns
    -------
    tuple of list of pathlib.Path and dict
        The zips and the index.

    Raises
    ------
    SystemExit
        Blender's tool did not take all of them into the index.
    """
    for old in [*folder.glob("*.zip"), *folder.glob("index.*")]:
        old.unlink()
    zips = build(platforms, pythons, folder, **options)
    index = write_index(folder)
    if len(index["data"]) != len(zips):
        sys.exit(f"{folder / 'index.json'} lists {len(index['data'])} of {len(zips)} zips.")
    return zips, index


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", default="all", help="all, current, or one of Blender's platform names")
    parser.add_argument("--python", default="all", help="all, current, or one of Blender's Pythons")
    parser.add_argument("--out", type=Path, default=DIST, help="by default dist/")
    arguments = parser.parse_args()
    if check_manifest():
        sys.exit(1)
    manifest, _ = load_manifest()
    for path in release(arguments.out, chosen_platforms(arguments.platform), chosen_pythons(arguments.python))[0]:
        print(f"{path.name}  {path.stat().st_size / 1e6:.1f} MB")
    print(f"{arguments.out / 'index.json'}  what Blender's remote repositories read, once a server shows the folder")
    if any(read_changelog().unreleased.values()):
        print(
            f"CHANGELOG.md lists changes under [Unreleased], and these zips hold them as {manifest['version']}. Before"
            " you publish, give them a version and a date, and it to pyproject.toml and blender_manifest.toml."
        )


if __name__ == "__main__":
    main()
