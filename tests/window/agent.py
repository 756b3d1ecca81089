# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender's window: executes the Python that a test hands in, and logs when the event loop stood still
and how long its thread worked meanwhile.

Needs ``WINDOW_AGENT_FOLDER``. A file ``N.in`` there is run and answered by ``N.out`` or ``N.err``.
"""

import ast
import contextlib
import io
import os
import time
import traceback
from pathlib import Path

import bpy

FOLDER = Path(os.environ["WINDOW_AGENT_FOLDER"])
PERIOD = 0.02  # s between two beats
NAMES = {"bpy": bpy, "__name__": "window"}
last = time.perf_counter(), time.thread_time()
beats = 0


def execute(path):
    """Run one file; what it printed, or the value of its last expression, is the answer."""
    source = path.read_text(encoding="utf-8")
    path.unlink()
    printed, suffix = io.StringIO(), ".out"
    with contextlib.redirect_stdout(printed):
        try:
            body = ast.parse(source).body
            value = ast.Expression(body.pop().value) if body and isinstance(body[-1], ast.Expr) else None
            exec(compile(ast.Module(body, []), "test", "exec"), NAMES)
            if value is not None and (value := eval(compile(value, "test", "eval"), NAMES)) is not None:
                print(value)
        except BaseException:  # also SystemExit: the window is to stay
            traceback.print_exc(file=printed)
            suffix = ".err"
    part = path.with_suffix(".part")
    part.write_text(printed.getvalue(), encoding="utf-8")
    part.rename(path.with_suffix(suffix))


def beat():
    global last, beats
    gap, busy = time.perf_counter() - last[0], time.thread_time() - last[1]
    beats += 1
    if beats == 10:
        (FOLDER / "ready").touch()
    if beats > 10:
        with open(FOLDER / "gaps.log", "a", encoding="utf-8") as file:
            if gap > 0.05:
                file.write(f"{gap:.3f} {busy:.3f}\n")
    last = time.perf_counter(), time.thread_time()  # what is executed counts: an operator may run in it
    for path in sorted(FOLDER.glob("*.in")):
        execute(path)
    return PERIOD


bpy.context.preferences.view.show_splash = False  # it would take the first click
bpy.app.timers.register(beat, persistent=True)
