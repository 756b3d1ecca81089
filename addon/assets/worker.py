# SPDX-License-Identifier: GPL-3.0-or-later
"""The second Blender that makes the asset library: how it is started and watched, and what it runs."""

from __future__ import annotations

import queue
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import IO

import bpy

from ...precompute.errors import DiffractionError

#: Begins a line of progress: then the fraction and what is being made.
_MARK = "DIFFRACTION-ASSETS"

_PACKAGE = __package__.rpartition(".addon")[0]


def command(target: Path, implementation: str, only: tuple[str, ...] = ()) -> list[str]:
    """What to start, for all materials or those of some presets; empty where this is Blender as a module."""
    if not bpy.app.binary_path:
        return []
    code = (
        "import addon_utils, importlib; "
        f"addon_utils.enable({_PACKAGE!r}); "
        f"importlib.import_module({__name__!r}).main({str(target)!r}, {implementation!r}, {only!r})"
    )
    # The settings of the user are not loaded: their start-up scripts and add-ons have no say in the library.
    return [
        bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1", "--python-expr", code,
    ]  # fmt: skip


def run(words: list[str], progress: Callable[[str, float], None]) -> int:
    """Start it and hand its progress on; the number of materials.

    Raises
    ------
    DiffractionError
        If it fails, with its last words. Cancelled, from `progress`, ends it.
    """
    process = subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, encoding="utf-8", errors="replace"
    )
    last, count, now = "", 0, ("start", 0.0)
    # Read beside this: a bake or a render says nothing for long, and a user who stops does not want to wait for it.
    lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
    threading.Thread(target=_read, args=(process.stdout, lines), name="diffraction-assets", daemon=True).start()
    try:
        while True:
            progress(*now)  # raises where the user stops
            try:
                line = lines.get(timeout=0.2)
            except queue.Empty:
                continue
            if line is None:
                break
            if line.startswith(_MARK):
                _, fraction, name = line.strip().split(" ", 2)
                now = (name, float(fraction))
                count += name != "done"
            elif line.strip():
                last = line.strip()
        progress(*now)
        if process.wait() or not count:
            raise DiffractionError(f"The asset library could not be made: {last or 'the second Blender ended'}")
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
    return count


def _read(stream: IO[str] | None, lines: queue.SimpleQueue[str | None]) -> None:
    """Hand over what a process prints, and None at its end."""
    for line in stream or ():
        lines.put(line)
    lines.put(None)


def main(target: str, implementation: str, only: tuple[str, ...] = ()) -> None:
    """Make the library and tell the progress; in the second Blender."""
    from .library import build_assets

    def tell(name: str, fraction: float) -> None:
        print(f"{_MARK} {fraction:.3f} {name}", flush=True)

    build_assets(Path(target), only, implementation=implementation, progress=tell)
    sys.stdout.flush()
