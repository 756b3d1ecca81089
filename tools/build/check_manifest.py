# SPDX-License-Identifier: GPL-3.0-or-later
"""Check blender_manifest.toml where Blender's own `validate` does not look: licence, tags, platforms, wheels, wording.

`check_manifest.py` prints one sentence for each problem; exit code 1 where there is any.
"""

import sys
import tomllib
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path


from tools.build.blender_files import valid_tags
from tools.build.changelog import read_changelog
from tools.build.fetch_wheels import PLATFORMS, ROOT, bundled_name, pins_by_python, read_lock, runs_on
from tools.build.requirements import BLENDERS

# https://docs.blender.org/manual/en/latest/advanced/extensions/getting_started.html
KNOWN_PERMISSIONS = {"files", "network", "clipboard", "camera", "microphone"}
KNOWN_PLATFORMS = {"linux-x64", "linux-arm64", "windows-x64", "windows-arm64", "macos-x64", "macos-arm64"}
LONGEST_LINE = 64


def load_manifest():
    """The manifest and pyproject.toml's `[project]` table, as dicts."""
    manifest = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return manifest, project


def wording_problems(manifest):
    """Sentences about the tagline and the permissions' reasons: short, and no full stop at the end."""
    lines = {"tagline": manifest.get("tagline", "")}
    for name, reason in manifest.get("permissions", {}).items():
        lines[f"permission {name!r}"] = reason
        if name not in KNOWN_PERMISSIONS:
            yield f"The permission {name!r} is not one of {', '.join(sorted(KNOWN_PERMISSIONS))}."
    for label, line in lines.items():
        if not line or len(line) > LONGEST_LINE:
            yield f"The text of the {label} has {len(line)} characters: 1 to {LONGEST_LINE} are allowed."
        elif not line[-1].isalnum():
            yield f"The text of the {label} ends with {line[-1]!r}: it must end with a letter or digit."


def identity_problems(manifest, project, tags):
    """Sentences about id, version, licence, tags and platforms."""
    if manifest.get("schema_version") != "1.0.0":
        yield "The schema_version must be 1.0.0."
    if manifest.get("id") != "diffraction_shader":
        yield "The id must be diffraction_shader: saved files and scripts refer to it."
    if manifest.get("version") != project["version"]:
        yield f"The version {manifest.get('version')} differs from {project['version']} in pyproject.toml."
    if manifest.get("license") != [f"SPDX:{project['license']}"]:
        yield f"The license must be ['SPDX:{project['license']}'], as in pyproject.toml."
    for tag in sorted(set(manifest.get("tags", [])) - tags):
        yield f"The tag {tag!r} is not on Blender's list of add-on tags."
    if not manifest.get("tags"):
        yield "There are no tags."
    for name in sorted(set(manifest.get("platforms", [])) - KNOWN_PLATFORMS):
        yield f"The platform {name!r} is unknown to Blender."
    if set(manifest.get("platforms", [])) != set(PLATFORMS):
        yield f"The platforms must be those of tools/build/fetch_wheels.py: {', '.join(PLATFORMS)}."


def changelog_problems(manifest, changelog):
    """Sentences about CHANGELOG.md: its newest version is the manifest's, so that never falls behind an earlier one."""
    yield from changelog.problems
    newest = next(iter(changelog.releases), None)
    if newest is not None and newest != manifest.get("version"):
        yield f"The version {manifest.get('version')} differs from {newest}, the newest in CHANGELOG.md."
    if newest is None:
        yield f"CHANGELOG.md does not tell what {manifest.get('version')} holds."


def version(text):
    """A version such as "4.5.0" as numbers, which compare."""
    return tuple(map(int, text.split(".")))


def blender_problems(manifest, blenders):
    """Sentences about the Blenders: the zips' ranges begin with the oldest tested one, meet, and have no end.

    Parameters
    ----------
    manifest : dict
    blenders : dict of str to tuple of str and (str or None)
        Of each Python the first Blender and the first that is too new, see `requirements.BLENDERS`.
    """
    ranges = sorted(blenders.values(), key=lambda pair: version(pair[0]))
    first = manifest.get("blender_version_min", "")
    if first != ranges[0][0]:
        yield f"The blender_version_min {first} differs from {ranges[0][0]}, where the first zip's range begins."
    if version(ranges[0][0]) < (4, 5):
        yield "The blender_version_min must be 4.5.0 or later: older ones are not tested."
    if "blender_version_max" in manifest:
        yield "The manifest must hold no blender_version_max: each zip gets its own."
    for (_, too_new), following in zip(ranges, [*(pair[0] for pair in ranges[1:]), None], strict=True):
        if too_new != following:
            yield f"A zip's range ends at {too_new}, and the next begins at {following}: no zip or two for some."


def fits(wheel, python):
    """Whether Blender unpacks a wheel for a Python such as "3.11": its tags name that version, or any Python 3."""
    digits = python.replace(".", "")
    tags, abi = wheel.removesuffix(".whl").split("-")[2:4]
    return any(
        tag in {"py3", f"py{digits}"} or (tag == f"cp{digits}" and abi in {f"cp{digits}", "abi3"})
        for tag in tags.split(".")
    )


def wheel_problems(manifest, pins, lock):
    """Sentences about the wheels: each pin once on each platform for each Python, locked, and never numpy."""
    wheels = [path.removeprefix("./wheels/") for path in manifest.get("wheels", [])]
    locked = [bundled_name(wheel, pins) for wheel in lock]
    if sorted(wheels) != sorted(locked):
        differing = ", ".join(sorted(set(wheels) ^ set(locked))) or "one is listed twice"
        yield f"The wheels differ from tools/build/wheels.lock: {differing}."
    for wheel in wheels:
        if wheel.lower().startswith("numpy-"):
            yield f"{wheel} must not be bundled: Blender brings its own numpy."
        if not any(fits(wheel, python) for python in pins):
            yield f"{wheel} is for no Python of {', '.join(pins)}."
    for platform in PLATFORMS:
        for python in pins:
            fitting = [wheel for wheel in wheels if runs_on(wheel, platform) and fits(wheel, python)]
            for pin in pins[python]:
                name, version = pin.replace("-", "_").split("==")
                found = [wheel for wheel in fitting if wheel.startswith(f"{name}-")]
                if len(found) != 1 or found[0].split("-")[1] != version:
                    yield (
                        f"There are {len(found)} wheels of {name} for Python {python} on {platform}:"
                        f" there must be one, of {version}."
                    )


def problems(manifest, project, pins, lock, tags, changelog):
    """All that is wrong with a manifest.

    Parameters
    ----------
    manifest : dict
        Of blender_manifest.toml.
    project : dict
        The `[project]` table of pyproject.toml.
    pins : dict of str to list of str
        Run-time requirements for each Python.
    lock : dict of str to str
        Wheels and digests.
    tags : set of str
        Blender's own.
    changelog : tools.build.changelog.Changelog

    Returns
    -------
    list of str
        One sentence each; empty where all is well.
    """
    return [
        *identity_problems(manifest, project, tags),
        *wording_problems(manifest),
        *blender_problems(manifest, BLENDERS),
        *changelog_problems(manifest, changelog),
        *wheel_problems(manifest, pins, lock),
    ]


def main():
    found = problems(*load_manifest(), pins_by_python(), read_lock(), valid_tags(), read_changelog())
    for sentence in found:
        print(sentence, file=sys.stderr)
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
