# SPDX-License-Identifier: GPL-3.0-or-later
"""Bring the wheels that the extension bundles into wheels/: `fetch_wheels.py [--platform current|all|NAME] [--lock]`.

What is bundled are the run-time pins of pyproject.toml. tools/wheels.lock holds the SHA-256 of each wheel, so every
machine gets the same files; `--lock` resolves the pins anew for all platforms and rewrites it.
"""

import argparse
import hashlib
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

from requirements import ROOT, requirements

WHEELS = ROOT / "wheels"
LOCK = ROOT / "tools" / "wheels.lock"

# Blender's name of a platform and the wheel tags that run there (glibc 2.28, macOS 12: what Blender 5.2 asks for).
PLATFORMS = {
    "linux-x64": ("manylinux_2_28_x86_64", "manylinux_2_27_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"),
    "windows-x64": ("win_amd64",),
    "windows-arm64": ("win_arm64",),
    "macos-arm64": ("macosx_12_0_arm64",),
}
PYTHON = (ROOT / ".python-version").read_text(encoding="utf-8").strip()


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


def runs_on(wheel, name):
    """Whether a wheel's file name says that it runs on a platform (Blender's name)."""
    tag = wheel.removesuffix(".whl").rpartition("-")[2]
    if tag == "any":
        return True
    system, _, machine = name.partition("-")
    if system == "macos":
        return tag.startswith("macosx") and tag.endswith((machine, "universal2"))
    return any(part in PLATFORMS[name] for part in tag.split("."))


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


def download(pins, tags, folder):
    """Have pip download wheels, and nothing else, for the platform with these tags.

    Parameters
    ----------
    pins : sequence of str
        Lines of a requirements file.
    tags : sequence of str
        Platform tags of wheels.
    folder : pathlib.Path
    """
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as scratch:
        wanted = Path(scratch) / "requirements.txt"
        wanted.write_text("\n".join(pins) + "\n", encoding="utf-8")
        command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:"]
        command += ["--python-version", PYTHON, "--implementation", "cp", "--dest", str(folder)]
        for tag in tags:
            command += ["--platform", tag]
        subprocess.run([*command, "--requirement", str(wanted)], check=True)


def fetch(platforms):
    """Bring the locked wheels of some platforms into wheels/; what is there already stays.

    Returns
    -------
    list of str
        Their file names, sorted.
    """
    lock = read_lock()
    names = sorted(wheel for wheel in lock if any(runs_on(wheel, name) for name in platforms))
    for name in platforms:
        absent = [
            wheel
            for wheel in names
            if runs_on(wheel, name) and not ((WHEELS / wheel).is_file() and sha256(WHEELS / wheel) == lock[wheel])
        ]
        if not absent:
            continue
        pins = {pin.partition("==")[0].replace("-", "_"): pin for pin in requirements()}
        lines = [f"{pins[wheel.partition('-')[0]]} --hash=sha256:{lock[wheel]}" for wheel in absent]
        for wheel in absent:
            (WHEELS / wheel).unlink(missing_ok=True)
        download(lines, PLATFORMS[name], WHEELS)
    for wheel in names:
        if not (WHEELS / wheel).is_file():
            sys.exit(
                f"{wheel} of tools/wheels.lock was not found: run `tools/fetch_wheels.py --lock` after changing pins."
            )
    return names


def write_lock():
    """Resolve the pins for all platforms and rewrite tools/wheels.lock."""
    digests = {}
    for name, tags in PLATFORMS.items():
        with tempfile.TemporaryDirectory() as scratch:
            download(requirements(), tags, Path(scratch))
            for path in Path(scratch).iterdir():
                digests[path.name] = sha256(path)
                WHEELS.mkdir(exist_ok=True)
                (WHEELS / path.name).write_bytes(path.read_bytes())
        print(f"{name}: resolved", file=sys.stderr)
    head = "# The wheels that the extension bundles; written by `tools/fetch_wheels.py --lock`.\n"
    body = "".join(f"{digests[name]}  {name}\n" for name in sorted(digests))
    LOCK.write_text(head + body, encoding="utf-8")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--platform", default="current", help="current, all, or one of Blender's platform names")
    parser.add_argument("--lock", action="store_true", help="resolve the pins anew and rewrite tools/wheels.lock")
    arguments = parser.parse_args()
    if arguments.lock:
        write_lock()
    print("\n".join(fetch(chosen_platforms(arguments.platform))))


if __name__ == "__main__":
    main()
