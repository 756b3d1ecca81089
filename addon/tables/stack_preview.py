# SPDX-License-Identifier: GPL-3.0-or-later
"""The plot of a stack's reflectance as an icon of the panel; no data-block of the file is made for it."""

from __future__ import annotations

from typing import Any

import numpy as np

#: Most pictures that are kept.
_KEPT = 16

_previews: Any = None
_known: dict[tuple[str, str, str], tuple[int, str]] = {}


def plot(substrate: str, films: str, lacquer: str) -> tuple[int, str]:
    """Icon for `UILayout.template_icon`, and the words that explain it.

    Parameters
    ----------
    substrate, films, lacquer
        As the panel has them typed.

    Raises
    ------
    DiffractionError
        If there is no such material or film.
    """
    global _previews
    key = (substrate, films, lacquer)
    if key in _known:
        return _known[key]
    from bpy.utils import previews

    from ...precompute.evaluate.stack_plot import stack_plot
    from .bake_settings import stuff

    made = stuff(*key)
    picture, least, largest = stack_plot(made["stack"], made["lacquer"])
    if _previews is None:
        _previews = previews.new()
    if len(_known) >= _KEPT:
        _known.clear()
        _previews.clear()
    height, width, _ = picture.shape
    pixels = np.ones((height, width, 4), np.float32)
    pixels[..., :3] = picture
    made_preview = _previews.new(" | ".join(key))
    made_preview.image_size = (width, height)
    made_preview.image_pixels_float.foreach_set(pixels.ravel())
    _known[key] = made_preview.icon_id, f"R from {100 * least:.0f} (black) to {100 * largest:.0f} % (white)"
    return _known[key]


def drop() -> None:
    """Free the pictures."""
    global _previews
    _known.clear()
    if _previews is not None:
        from bpy.utils import previews

        previews.remove(_previews)
        _previews = None
