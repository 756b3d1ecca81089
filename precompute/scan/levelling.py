# SPDX-License-Identifier: GPL-3.0-or-later
"""Levelling: taking the tilt and the bow of the sample or the scanner out of a heightfield."""

from __future__ import annotations

import numpy as np

from ..errors import ParameterError
from .heightfield import HeightField

#: Exponents (of x, of y) of each method's polynomial.
_TERMS = {
    "plane": ((0, 0), (1, 0), (0, 1)),
    "poly2": ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)),
}
METHODS = ("none", *_TERMS)


def level(field: HeightField, method: str) -> HeightField:
    """Subtract the least-squares polynomial of the valid pixels.

    Parameters
    ----------
    field
        The heightfield; missing points take no part in the fit and stay missing.
    method
        ``none`` (the field as it is), ``plane`` (order 1) or ``poly2`` (all terms up to order 2).

    Returns
    -------
    HeightField
        Heights in metres whose valid pixels have the mean 0.

    Raises
    ------
    ParameterError
        If the method is not known.
    """
    if method == "none":
        return field
    if method not in _TERMS:
        raise ParameterError(f"There is no levelling '{method}'; choose one of {', '.join(METHODS)}.")
    surface = fitted_surface(field.heights, ~field.missing, method)
    heights = field.heights - surface
    heights -= heights[~field.missing].mean()
    return field.processed({"step": "level", "method": method}, heights=heights)


def fitted_surface(heights: np.ndarray, valid: np.ndarray, method: str) -> np.ndarray:
    """The least-squares polynomial through the valid pixels, at every pixel.

    The normal equations come from moments: sums of ``x^i y^j`` and ``x^i y^j h`` over the valid
    pixels, which factor into two small matrix products. On 1332 x 1332 pixels that is a hundred
    times faster than a general least-squares solver, and with coordinates in [-1, 1] as accurate.

    Parameters
    ----------
    heights
        ``(rows, cols)`` metres.
    valid
        ``(rows, cols)`` bool.
    method
        ``plane`` or ``poly2``.

    Returns
    -------
    numpy.ndarray
        ``(rows, cols)`` metres.
    """
    terms = _TERMS[method]
    rows, cols = heights.shape
    order = max(max(term) for term in terms)
    x = np.linspace(-1.0, 1.0, cols)[:, None] ** np.arange(2 * order + 1)
    y = np.linspace(-1.0, 1.0, rows)[:, None] ** np.arange(2 * order + 1)
    if valid.all():
        counts = np.outer(y.sum(axis=0), x.sum(axis=0))
        offset = heights.mean()
        centred = heights - offset
    else:
        counts = y.T @ (valid.astype(np.float64) @ x)
        offset = heights[valid].mean()
        centred = np.where(valid, heights - offset, 0.0)
    moments = y[:, : order + 1].T @ (centred @ x[:, : order + 1])
    matrix = np.array([[counts[j + n, i + m] for m, n in terms] for i, j in terms])
    right = np.array([moments[j, i] for i, j in terms])
    # lstsq and not solve: too few valid pixels leave some terms open, and the smallest solution is the sane one.
    solution = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
    coefficients = np.zeros((order + 1, order + 1))
    for (i, j), value in zip(terms, solution, strict=True):
        coefficients[j, i] = value
    return offset + y[:, : order + 1] @ coefficients @ x[:, : order + 1].T
