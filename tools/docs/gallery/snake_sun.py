# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample scene's snake in the sun."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import bpy

from . import stage

ROOT = Path(__file__).resolve().parents[3]


def sample_scene():
    """The module that builds the sample scene; it is no part of the extension."""
    spec = importlib.util.spec_from_file_location("build_scene", ROOT / "sample_blend" / "build_scene.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


def build(out):
    """The scene."""
    stage.empty_room(out / "snake_sun.blend")
    bodies = sample_scene().build_scene()
    stage.diffract(bodies, "snake")
    scene = bpy.context.scene
    lens = scene.camera.data
    lens.lens = 66
    lens.dof.use_dof, lens.dof.focus_distance, lens.dof.aperture_fstop = True, 2.55, 1.8
