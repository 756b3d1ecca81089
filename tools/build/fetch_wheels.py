# SPDX-License-Identifier: GPL-3.0-or-later
"""Bring the wheels that the extension bundles into wheels/: `fetch_wheels.py [--platform current|all|NAME] [--lock]`.

`--python 3.13` (or 3.11, or current) takes the wheels of one Python alone.

What is bundled are the run-time pins of pyproject.toml, for the Pythons of all Blenders. wheels.lock, beside this file,
holds the SHA-256 of each wheel, so every machine gets the same files; `--lock` resolves the pins anew for all platforms
and rewrites it.
"""

import argparse
import hashlib
import itertools
import platform
import re
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # a script: its folder alone is on the path


from tools.build.requirements import PYTHONS, ROOT, requirements

WHEELS = ROOT / "wheels"
LOCK = ROOT / "tools" / "build" / "wheels.lock"

# Blender's name of a platform and the wheel tags that run there (glibc 2.28, macOS 12: what Blender asks for).
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "windows-arm64": ("win_arm64",),
    "macos-arm64": ("macosx_12_0_arm64",),
}


#: Libraries whose wheel for all platforms does: fontTools' compiled parts hasten what nothing here does.
PURE = ("fonttools",)


def current_platform():
    """Blender's name of the platform this runs on, such as ``"linux-x64"``."""
    system = {"darwin": "macos"}.get(platform.system().lower(), platform.system().lower())
    machine = platform.machine().lower()
    return f"{system}-{ {'x86_64': 'x64', 'amd64': 'x64', 'aarch64': 'arm64'}.get(machine, machine) }"


def chosen_platforms(name):
    """The platforms that ``"all"``, ``"current"`` or a name stands for.

    Raises
    ------
    SystemExit
        The extension is not built for that platform.
    """
    if name == "all":
        return list(PLATFORMS)
    name = current_platform() if name == "current" else name
    if name not in PLATFORMS:
        sys.exit(f"The extension is not built for {name}: choose one of {', '.join(PLATFORMS)}.")
    return [name]


def chosen_pythons(name):
    """The Pythons that ``"all"``, ``"current"`` or a version stands for.

    Raises
    ------
    SystemExit
        The extension is not built for that Python.
    """
    if name == "all":
        return list(PYTHONS)
    name = "{}.{}".format(*sys.version_info) if name == "current" else name
    if name not in PYTHONS:
        sys.exit(f"The extension is not built for Python {name}: choose one of {', '.join(PYTHONS)}.")
    return [name]


def runs_on(wheel, name):
    """Whether a wheel's file name says that it runs on a platform (Blender's name)."""
    tag = wheel.removesuffix(".whl").rpartition("-")[2]
    if tag == "any":
        return True
    system, _, machine = name.partition("-")
    if system == "macos":
        return tag.startswith("macosx") and tag.endswith((machine, "universal2"))
    return any(part in PLATFORMS[name] for part in tag.split("."))


def pins_by_python():
    """The run-time pins of each Python.

    Returns
    -------
    dict of str to list of str
    """
    return {python: requirements(python=python) for python in PYTHONS}


def pythons_of(wheel, pins):
    """The Pythons, among the keys of `pins`, that a wheel's name, version and tags are for."""
    name, version, tag = wheel.split("-")[0], wheel.split("-")[1], wheel.split("-")[2]
    return [
        python
        for python, wanted in pins.items()
        if f"{name}=={version}" in [pin.lower().replace("-", "_") for pin in wanted]
        and (tag.startswith("py") or tag == "cp" + python.replace(".", ""))
    ]


def bundled_name(wheel, pins):
    """What a wheel is called in the zip.

    Blender unpacks, of all listed wheels of one name that fit its Python, that of the highest version. A pure wheel
    fits any Python 3, so one that only some Python's pins hold is tagged with that Python.
    """
    found = pythons_of(wheel, pins)
    if not wheel.endswith("-none-any.whl") or len(found) == len(pins):
        return wheel
    tags = ".".join("py" + python.replace(".", "") for python in found)
    return re.sub(r"-[^-]+-none-any\.whl$", f"-{tags}-none-any.whl", wheel)


def read_lock():
    """Wheel names and their SHA-256.

    Returns
    -------
    dict of str to str
    """
    lines = LOCK.read_text(encoding="utf-8").splitlines()
    return {name: digest for digest, name in (line.split() for line in lines if not line.startswith("#"))}


def sha256(path):
    """SHA-256 of a file as a hexadecimal string."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def download(pins, tags, python, folder):
    """Have pip download wheels, and nothing else, for the platform with these tags.

    Parameters
    ----------
    pins : sequence of str
        Lines of a requirements file.
    tags : sequence of str
        Platform tags of wheels.
    python : str
        Version of Python, such as ``"3.11"``.
    folder : pathlib.Path
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        wanted = Path(scratch) / "requirements.txt"
        wanted.write_text("\n".join(pins) + "\n", encoding="utf-8")
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
        command += ["--python-version", python, "--dest", str(folder)]
        for tag in tags:
            command += ["--platform", tag]
        command += ["--implementation", "py" if tags == ("any",) else "cp"]
        subprocess.run([*command, "--requirement", str(wanted)], check=True)


def fetch(platforms, pythons=PYTHONS):
    """Bring the locked wheels of some platforms and Pythons into wheels/; what is there already stays.

    Returns
    -------
    list of str
        Their file names, sorted.
    """
    lock, pins = read_lock(), pins_by_python()
    names = sorted(
        wheel
        for wheel in lock
        if any(runs_on(wheel, name) for name in platforms) and set(pythons) & set(pythons_of(wheel, pins))
    )
    for name in platforms:
        for python in pythons:
            absent = [
                wheel
                for wheel in names
                if runs_on(wheel, name)
                and python in pythons_of(wheel, pins)
                and not ((WHEELS / wheel).is_file() and sha256(WHEELS / wheel) == lock[wheel])
            ]
            for wheel in absent:
                (WHEELS / wheel).unlink(missing_ok=True)
            for pure in (True, False):
                lines = [
                    f"{'=='.join(wheel.split('-')[:2])} --hash=sha256:{lock[wheel]}"
                    for wheel in absent
                    if wheel.endswith("-none-any.whl") == pure
                ]
                if lines:
                    download(lines, ("any",) if pure else PLATFORMS[name], python, WHEELS)
    for wheel in names:
        if not (WHEELS / wheel).is_file():
            sys.exit(
                f"{wheel} of tools/build/wheels.lock was not found: "
                "run `tools/build/fetch_wheels.py --lock` after changing pins."
            )
    return names


def write_lock():
    """Resolve the pins for all platforms and rewrite tools/build/wheels.lock."""
    digests = {}
    for name, python in itertools.product(PLATFORMS, PYTHONS):
        with tempfile.TemporaryDirectory() as scratch:
            pins = requirements(python=python)
            pure = [pin for pin in pins if pin.split("==")[0] in PURE]
            download(sorted(set(pins) - set(pure)), PLATFORMS[name], python, Path(scratch))
            download(pure, ("any",), python, Path(scratch))
            for path in Path(scratch).iterdir():
                digests[path.name] = sha256(path)
                WHEELS.mkdir(exist_ok=True)
                (WHEELS / path.name).write_bytes(path.read_bytes())
        print(f"{name}, Python {python}: resolved", file=sys.stderr)
    head = "# The wheels that the extension bundles; written by `tools/build/fetch_wheels.py --lock`.\n"
    body = "".join(f"{digests[name]}  {name}\n" for name in sorted(digests))
    LOCK.write_text(head + body, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", default="current", help="current, all, or one of Blender's platform names")
    parser.add_argument("--python", default="all", help="current, all, or one of Blender's Pythons")
    parser.add_argument("--lock", action="store_true", help="resolve the pins anew and rewrite tools/build/wheels.lock")
    arguments = parser.parse_args()
    if arguments.lock:
        write_lock()
    print("\n".join(fetch(chosen_platforms(arguments.platform), chosen_pythons(arguments.python))))


if __name__ == "__main__":
    main()
