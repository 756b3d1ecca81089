# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators take from the panel what their caller did not give."""

from __future__ import annotations

from collections.abc import Iterable

import bpy


def take(operator: bpy.types.Operator, context: bpy.types.Context, names: Iterable[str], prefix: str = "") -> None:
    """Set properties of an operator that were not given to the scene's, whose names may begin with a prefix."""
    for name in names:
        if not operator.properties.is_property_set(name, ghost=False):
            setattr(operator, name, getattr(context.scene.diffraction, prefix + name))
