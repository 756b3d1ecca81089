# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators: they read properties, call the core and write the scene."""

from . import apply_material, bake, import_scan, make_preset

CLASSES = (*import_scan.CLASSES, *make_preset.CLASSES, *bake.CLASSES, *apply_material.CLASSES)
