# SPDX-License-Identifier: GPL-3.0-or-later
"""Flips and quarter turns: instruments and programs disagree on where a scan begins."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import ParameterError
from .heightfield import HeightField

_OTHER_AXIS = {"x": "y", "y": "x"}


def flip_x(field: HeightField) -> HeightField:
    """Left and right exchanged."""
    return field.processed({"step": "flip x"}, heights=field.heights[:, ::-1], missing=field.missing[:, ::-1])


def flip_y(field: HeightField) -> HeightField:
    """Bottom and top exchanged."""
    return field.processed({"step": "flip y"}, heights=field.heights[::-1], missing=field.missing[::-1])


def rotate90(field: HeightField, turns: int = 1) -> HeightField:
    """Quarter turns anticlockwise, seen from above: what lay on the right (+x) lies at the top (+y) after one.

    Parameters
    ----------
    field
        The heightfield.
    turns
        Number of quarter turns; negative ones go clockwise.

    Raises
    ------
    ParameterError
        If ``turns`` is no whole number.
    """
    if int(turns) != turns:
        raise ParameterError(f"A scan turns by whole quarters, not by {turns}; give a whole number.")
    turns = int(turns) % 4
    if turns == 0:
        return field
    changes: dict[str, Any] = {
        # numpy's rot90 turns anticlockwise where row 0 is the top; here row 0 is the bottom.
        "heights": np.rot90(field.heights, -turns),
        "missing": np.rot90(field.missing, -turns),
    }
    if turns % 2:
        changes |= {"dx": field.dy, "dy": field.dx}
        axis = field.metadata.get("fast_axis")
        if axis in _OTHER_AXIS:
            changes["metadata"] = {**field.metadata, "fast_axis": _OTHER_AXIS[axis]}
    return field.processed({"step": "rotate", "quarter_turns": turns}, **changes)
