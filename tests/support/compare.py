# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare a rendered image with its reference and leave both, and their difference, where a person can look."""

from pathlib import Path

import numpy as np

OUT = Path(__file__).resolve().parents[2] / "out" / "failed"


def relative_error(result, reference, floor=0.0):
    """Error of each pixel relative to the reference.

    Parameters
    ----------
    result, reference : array_like, shape (..., c)
    floor : float
        Smallest denominator, in the units of the images.

    Returns
    -------
    numpy.ndarray, shape (...)
        Norm over the channels of the difference over that of the reference.
    """
    result, reference = np.asarray(result, dtype=float), np.asarray(reference, dtype=float)
    size = np.linalg.norm(reference, axis=-1)
    return np.linalg.norm(result - reference, axis=-1) / np.maximum(size, max(floor, np.finfo(float).tiny))


def assert_images_agree(result, reference, tolerance, percentile=99.0, where=None, floor=0.0, name="image"):
    """Fail, and leave `out/failed/NAME_{reference,result,error}.png`, where two images differ.

    Parameters
    ----------
    result, reference : array_like, shape (rows, columns, 3)
        Linear RGB, row 0 at the bottom.
    tolerance : float
        Largest relative error allowed at the percentile.
    percentile : float
        Of the relative errors of the pixels compared.
    where : array_like of bool, shape (rows, columns), optional
        Pixels to compare; at least one is needed, else nothing would be shown.
    floor : float
        Smallest denominator of the relative error.
    name : str
        What the files are called.
    """
    result, reference = np.asarray(result, dtype=float), np.asarray(reference, dtype=float)
    assert result.shape == reference.shape, f"{name}: shapes {result.shape} and {reference.shape} differ"
    error = relative_error(result, reference, floor)
    where = np.ones(error.shape, bool) if where is None else np.asarray(where, bool)
    assert where.any(), f"{name}: no pixel to compare"
    reached = np.percentile(error[where], percentile)
    if not reached <= tolerance:  # a NaN fails too
        leave_images(result, reference, np.where(where, error, 0.0), name)
        raise AssertionError(
            f"{name}: relative error {reached:.4g} at percentile {percentile:g} is above {tolerance:g}; see {OUT}"
        )


def leave_images(result, reference, error, name):
    """Write reference, result and error as PNG files into `out/failed/`."""
    import matplotlib.image

    OUT.mkdir(parents=True, exist_ok=True)
    white = max(np.nanpercentile(reference, 99.5), np.finfo(float).tiny)
    for label, image in (("reference", reference), ("result", result)):
        matplotlib.image.imsave(
            OUT / f"{name}_{label}.png", np.clip(np.nan_to_num(image) / white, 0, 1)[::-1] ** (1 / 2.2)
        )
    matplotlib.image.imsave(OUT / f"{name}_error.png", error[::-1], vmin=0.0, vmax=max(4 * np.nanmedian(error), 1e-12))
