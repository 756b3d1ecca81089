# SPDX-License-Identifier: GPL-3.0-or-later
"""A GPU context for whoever draws or computes, in background mode too."""

from __future__ import annotations

import bpy

from ..precompute.errors import ParameterError
from .versions import start_gpu


class NoGpu(ParameterError):
    """There is nothing to draw with."""


def ensure_gpu() -> None:
    """A GPU context, also in background mode.

    Raises
    ------
    NoGpu
        If this Blender cannot have one.
    """
    import gpu

    try:
        if bpy.app.background:
            start_gpu()
        gpu.platform.renderer_get()
    except Exception as error:
        raise NoGpu("Blender has no GPU context here, so the viewport cannot be drawn; render with Cycles.") from error
