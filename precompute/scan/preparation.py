# SPDX-License-Identifier: GPL-3.0-or-later
"""From a scan as it was read to the patch that is diffracted: crop, level, align, fill, clip, smooth, tile, refine."""

from __future__ import annotations

from ..parameters import BakeParameters
from .clipping import clip, crop
from .heightfield import HeightField
from .levelling import level
from .missing import fill_missing
from .replicas import replicate
from .resample import refine
from .row_alignment import align_rows
from .smoothing import smooth
from .tiling import make_tileable


def prepare(field: HeightField, parameters: BakeParameters) -> HeightField:
    """Apply the processing that ``parameters`` ask for, and what the physics needs.

    Parameters
    ----------
    field
        The scan as read.
    parameters
        ``crop_m``, ``level``, ``align_rows``, ``clip_percent``, ``smooth_m``, ``tile``, and for the ensemble
        ``periodic`` its ``replicas`` are used.

    Returns
    -------
    HeightField
        Levelled, without gaps, clipped, with pixels of at most lambda_min / 4 (coarser
        pixels would put false orders in view); every step is in its processing list.

    Raises
    ------
    SizeLimitError
        If refining would make the patch too large.
    ParameterError
        If the crop leaves nothing, the smoothing is wider than the patch, or there is no period to crop to.
    """
    # A scan too large to read whole was cropped while it was read.
    if parameters.crop_m is not None and field.metadata.get("cropped_m") != list(parameters.crop_m):
        left, right, bottom, top = parameters.crop_m
        field = crop(field, (left, right), (bottom, top))
    field = level(field, parameters.level)
    if parameters.align_rows != "none":
        field = align_rows(field, parameters.align_rows)
    field = fill_missing(field)
    if parameters.clip_percent is not None:
        field = clip(field, parameters.clip_percent)
    field = smooth(field, parameters.smooth_m)
    if parameters.tile != "none":
        field = make_tileable(field, parameters.tile)
    field = refine(field, parameters.pixel_max_m)
    return replicate(field, parameters.replicas) if parameters.ensemble == "periodic" else field
