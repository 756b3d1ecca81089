# SPDX-License-Identifier: GPL-3.0-or-later
"""DFT bins of a patch, their terms, and the part of them that is needed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...bake.series import Series, taylor_bound
from ...constants import FREQUENCY_MAX, KAPPA_MAX
from ...errors import ParameterError
from ...scan.heightfield import HeightField


@dataclass(frozen=True)
class Band:
    """A rectangle of the frequency plane: limits of fx = u / lambda and fy = v / lambda in 1/m."""

    fx: tuple[float, float] = (-FREQUENCY_MAX, FREQUENCY_MAX)
    fy: tuple[float, float] = (-FREQUENCY_MAX, FREQUENCY_MAX)


def axis_bins(step_hz: float, limits: tuple[float, float], margin: int) -> np.ndarray:
    """Whole numbers j whose frequencies j * step cover ``limits`` and ``margin`` bins beyond."""
    return np.arange(int(np.floor(limits[0] / step_hz)) - margin, int(np.ceil(limits[1] / step_hz)) + margin + 1)


def axis_kernel(count: int, step_m: float, frequencies: np.ndarray) -> np.ndarray:
    """``(len(frequencies), count)`` exp(2 pi i f x), x from the middle of the patch."""
    x = (np.arange(count) - (count - 1) / 2.0) * step_m
    return np.exp(2j * np.pi * np.outer(frequencies, x))


def make_terms(
    field: HeightField, series: str, tolerance: float, fy: np.ndarray, fx: np.ndarray, dtype: type = np.complex128
) -> tuple[Series, np.ndarray]:
    """The transforms of a series' terms on a grid of frequencies.

    Returns
    -------
    series : Series
        Gives the weight of each term at each kappa.
    terms : ndarray
        ``(terms, len(fy), len(fx))``: ``sum_pixels term exp(2 pi i f.x) dx dy`` in m^2, the phase 0 in the middle
        of the patch.
    """
    if series not in ("chebyshev", "taylor"):
        raise ParameterError(f"The series '{series}' has no terms; choose chebyshev or taylor.")
    kernel_y = axis_kernel(field.shape[0], field.dy, fy)
    kernel_x = axis_kernel(field.shape[1], field.dx, fx).T * (field.dx * field.dy)

    def transform(p: np.ndarray) -> np.ndarray:
        patch = p.ravel()[place].reshape(field.shape)
        # The narrower result first.
        return (kernel_y @ patch) @ kernel_x if len(fy) <= len(fx) else kernel_y @ (patch @ kernel_x)

    # Terms are functions of the height alone: a grating has few heights, and a Bessel function of each is enough.
    levels, place = np.unique(field.heights, return_inverse=True)
    place = place.ravel()
    made = Series(levels[None, :], np.ones((1, 1)), KAPPA_MAX, series, tolerance, transform)
    return made, np.stack([made.term(n).astype(dtype) for n in range(made.terms)])


def series_facts(series: Series, method: str, tolerance: float) -> dict[str, float | int | str]:
    """Name, number of terms, and for Taylor the argument x = kappa_max h_max and the bound at the chosen N."""
    facts: dict[str, float | int | str] = {"series": method, "terms": series.terms, "tolerance": tolerance}
    if method == "taylor":
        x = series.kappa_max * series.half_range
        facts |= {"x": x, "bound": taylor_bound(x, series.terms - 1)}
    return facts


def weights_matrix(series: Series, kappa: np.ndarray) -> np.ndarray:
    """``(terms, len(kappa))`` weights of the terms."""
    return np.stack([np.broadcast_to(series.weight(n, kappa), kappa.shape) for n in range(series.terms)])
