# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of one period side by side: the surface of the thesis's periodic method, as heights."""

from __future__ import annotations

import numpy as np

from ..errors import SizeLimitError
from .heightfield import HeightField
from .resample import LIMIT_PIXELS


def replicate(field: HeightField, replicas: tuple[int, int]) -> HeightField:
    """``replicas`` copies of a patch along x and y.

    Raises
    ------
    SizeLimitError
        If the copies together have more pixels than a patch may have.
    """
    along_x, along_y = replicas
    pixels = field.heights.size * along_x * along_y
    if pixels > LIMIT_PIXELS:
        raise SizeLimitError(
            f"{along_x} x {along_y} copies have {pixels / 1e6:.0f} million pixels, more than {LIMIT_PIXELS / 1e6:.0f}"
            " million; take fewer copies."
        )
    copies = (along_y, along_x)
    step = {"step": "replicate", "replicas": [along_x, along_y]}
    return field.processed(step, heights=np.tile(field.heights, copies), missing=np.tile(field.missing, copies))
