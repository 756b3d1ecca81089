# SPDX-License-Identifier: GPL-3.0-or-later
"""Row alignment: taking the offsets between scan lines out, on request only.

A microscope's lines may be offset against each other by drift. Subtracting each line's median
mends that, and erases a grating that runs along the lines just as well: what was removed is looked
at, and a strong period in it is told.
"""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from .heightfield import HeightField

#: A peak of the removed profile above this many medians of its spectrum is a period, not noise.
_PEAK_OVER_MEDIAN = 30.0
#: Smaller parts of the surface's variance are not worth a warning.
_LEAST_SHARE = 0.02


def align_rows(field: HeightField, axis: str = "x") -> HeightField:
    """Subtract the median of each scan line.

    Parameters
    ----------
    field
        The heightfield.
    axis
        The fast axis: ``x`` where lines are rows, ``y`` where they are columns.

    Returns
    -------
    HeightField
        Valid heights have the mean 0. The step carries the share of the variance that was removed, and
        ``warning`` where a strong spectral peak went with it.

    Raises
    ------
    ParameterError
        If the axis is neither ``x`` nor ``y``.
    """
    if axis not in ("x", "y"):
        raise ParameterError(f"There is no fast axis '{axis}'; choose x or y.")
    along = 1 if axis == "x" else 0
    values = np.where(field.missing, np.nan, field.heights)
    empty = field.missing.all(axis=along)
    profile = np.zeros(values.shape[1 - along])
    profile[~empty] = np.nanmedian(np.compress(~empty, values, axis=1 - along), axis=along)
    if empty.any():  # a line without a single valid point: its neighbours' offset
        places = np.arange(profile.size)
        profile[empty] = np.interp(places[empty], places[~empty], profile[~empty])
    heights = field.heights - (profile[:, None] if along == 1 else profile[None, :])
    heights -= heights[~field.missing].mean()
    step = {"step": "align rows", "axis": axis}
    warning = _warning(profile, field.dy if along == 1 else field.dx, float(field.valid.var()))
    if warning:
        step["warning"] = warning
    return field.processed(step, heights=heights)


def processing_warnings(field: HeightField) -> list[str]:
    """All warnings that processing steps left, in order."""
    return [step["warning"] for step in field.processing if step.get("warning")]


def _warning(profile: np.ndarray, step_m: float, variance: float) -> str:
    """A sentence about the strongest period in the removed profile, empty where there is none."""
    count = profile.size
    if count < 16 or variance <= 0.0:
        return ""
    x = np.linspace(-1.0, 1.0, count)
    rest = profile - np.polynomial.polynomial.polyval(x, np.polynomial.polynomial.polyfit(x, profile, 2))
    power = np.abs(np.fft.rfft(rest * np.hanning(count))) ** 2
    power[:3] = 0.0  # slower than three periods is drift or bow
    peak = int(np.argmax(power))
    total = power.sum()
    if total <= 0.0 or power[peak] < _PEAK_OVER_MEDIAN * np.median(power[3:]):
        return ""
    share = float(power[max(peak - 2, 0) : peak + 3].sum() / total * rest.var() / variance)
    if share < _LEAST_SHARE:
        return ""
    period = count * step_m / peak
    return (
        f"Row alignment removed a period of {1e6 * period:.3g} um that runs along the lines, "
        f"{100 * min(share, 1.0):.0f} percent of the surface's variance; "
        "leave it out if this is a structure, or choose the other axis."
    )
