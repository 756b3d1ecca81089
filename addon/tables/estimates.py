# SPDX-License-Identifier: GPL-3.0-or-later
"""What the next bake will cost, found in the background while the panel is looked at."""

from __future__ import annotations

import json
import threading
from dataclasses import dataclass
from typing import Any

import bpy

from ...precompute.errors import DiffractionError
from .. import paths
from ..jobs.threaded import redraw_sidebars
from . import bake_settings, recipe


@dataclass(frozen=True)
class Estimate:
    """Prediction or the reason why there is none.

    Parameters
    ----------
    cost
        `precompute.bake.cost.BakeCost`, or None.
    error
        One sentence, e.g. that the table would be too large.
    warnings
        What the preparation of the heights warns of.
    size_m
        Of the prepared patch.
    coherence
        `precompute.bake.window.Coherence`, the window in force, or None.
    """

    cost: Any = None
    error: str = ""
    warnings: tuple[str, ...] = ()
    size_m: tuple[float, float] = (0.0, 0.0)
    coherence: Any = None


_known: dict[str, Estimate] = {}
_at_work: dict[str, threading.Thread] = {}

#: Measured over predicted seconds of this machine, from the bakes of this session.
_speed = 1.0


def estimate(scene: bpy.types.Scene, wait: bool = False) -> Estimate | None:
    """The estimate for the panel's settings; None while it is being made.

    Parameters
    ----------
    scene
        With a scan.
    wait
        Make it here and now (scripts, tests).
    """
    state = scene.diffraction
    key = recipe.make(state)
    if key in _known or not state.scan_path:
        return _known.get(key)
    folder = paths.absolute(state.scan_path).parent
    try:
        chosen = bake_settings.parameters(state)
    except DiffractionError as error:
        return Estimate(error=str(error))
    if wait:
        return _make(key, folder, chosen)
    if key not in _at_work and len(_at_work) < 2:
        _at_work[key] = threading.Thread(target=_make, args=(key, folder, chosen), name="estimate", daemon=True)
        _at_work[key].start()
        if not bpy.app.background and not bpy.app.timers.is_registered(_watch):
            bpy.app.timers.register(_watch, first_interval=0.1)
    return None


def seconds(found: Estimate) -> float:
    """Predicted wall time, corrected by what earlier bakes took here."""
    return found.cost.seconds * _speed


def learn(scene: bpy.types.Scene, measured_s: float) -> None:
    """A bake of the panel's settings took so long."""
    global _speed
    found = _known.get(recipe.make(scene.diffraction))
    if found is not None and found.cost is not None and measured_s > 0.0:
        _speed = min(max(measured_s / found.cost.seconds, 0.1), 10.0)


def _make(key: str, folder: Any, chosen: Any) -> Estimate:
    from ...precompute.bake.baking import window_of
    from ...precompute.bake.cost import bake_cost
    from ...precompute.readers import read_scan
    from ...precompute.scan.preparation import prepare

    try:
        path, reading = recipe.scan_of(json.loads(key), folder)
        patch = prepare(read_scan(path, **reading), chosen)
        warnings = tuple(step["warning"] for step in patch.processing if step.get("warning"))
        window = window_of(patch, chosen)
        try:
            found = Estimate(bake_cost(patch, chosen), "", warnings, patch.size_m, window)
        except DiffractionError as error:
            found = Estimate(None, str(error), warnings, patch.size_m, window)
    except (DiffractionError, MemoryError, OSError) as error:
        found = Estimate(error=str(error))
    if len(_known) > 64:
        _known.clear()
    _known[key] = found
    _at_work.pop(key, None)
    return found


def _watch() -> float | None:
    """Timer: redraw the sidebar once an estimate is there."""
    if _at_work:
        return 0.1
    redraw_sidebars(bpy.context)
    return None


def unregister() -> None:
    """Forget everything."""
    if bpy.app.timers.is_registered(_watch):
        bpy.app.timers.unregister(_watch)
    _known.clear()
