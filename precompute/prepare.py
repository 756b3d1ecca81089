# SPDX-License-Identifier: GPL-3.0-or-later
"""From a scan as it was read to the patch that is diffracted: level, fill, clip, refine."""

from __future__ import annotations

from .clipping import clip
from .constants import PIXEL_MAX_M
from .heightfield import HeightField
from .levelling import level
from .missing import fill_missing
from .parameters import BakeParameters
from .resample import refine


def prepare(field: HeightField, parameters: BakeParameters) -> HeightField:
    """Apply the processing that ``parameters`` ask for, and what the physics needs.

    Parameters
    ----------
    field
        The scan as read.
    parameters
        ``level`` and ``clip_percent`` are used.

    Returns
    -------
    HeightField
        Levelled, without gaps, clipped, with pixels of at most lambda_min / 4 (coarser
        pixels would put false orders in view); every step is in its processing list.

    Raises
    ------
    SizeLimitError
        If refining would make the patch too large.
    """
    field = level(field, parameters.level)
    field = fill_missing(field)
    if parameters.clip_percent is not None:
        field = clip(field, parameters.clip_percent)
    return refine(field, PIXEL_MAX_M)
