# SPDX-License-Identifier: GPL-3.0-or-later
"""Terms of a series as image textures: one complex DFT a term, like the thesis's precomputation.

Term n is the inverse DFT (sign +) of a function of the heights (see :mod:`precompute.bake.series`), without a
window, on the bins of the patch: the windowed methods convolve with the window's transform afterwards
(thesis eq. 3.28). Only bins that light of 380 nm can reach, |f| <= 2 / lambda_min, are kept.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..constants import FREQUENCY_MAX, KAPPA_MAX, TERMS_FORMAT_VERSION
from ..errors import TableError
from ..files.atomic import atomic_path
from ..files.exr import write_image
from ..files.output_folder import ensure_folder
from ..parameters import BakeParameters
from ..scan.heightfield import HeightField
from .series import Series, check_single_precision, term_weight


@dataclass(frozen=True)
class Terms:
    """Terms of one series.

    Parameters
    ----------
    images
        ``(n, rows, cols)`` complex64; bin (row, col) stands for the frequency
        ``(fx[col], fy[row])``, both ascending. Sums over pixels, no pixel area.
    fx, fy
        Bin frequencies in 1/m.
    method
        ``taylor`` or ``chebyshev``.
    kappa_max, half_range
        1/m and m; they set the weights.
    key
        That of the table they were stored with (``SpectralTable.info["key"]``), empty where there is none.
    """

    images: np.ndarray
    fx: np.ndarray
    fy: np.ndarray
    method: str
    kappa_max: float
    half_range: float
    key: str = ""

    def evaluate(self, kappa: float) -> np.ndarray:
        """``(rows, cols)`` sum of exp(-i kappa h) exp(2 pi i f.x) on the bins, up to a phase."""
        weights = [term_weight(self.method, n, kappa, self.kappa_max, self.half_range) for n in range(len(self.images))]
        return np.tensordot(np.array(weights), self.images.astype(np.complex128), 1)


def _band(pixels: int, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Indices into the DFT (ascending frequency) and the frequencies that visible light reaches."""
    frequencies = np.fft.fftshift(np.fft.fftfreq(pixels, step))
    reach = FREQUENCY_MAX + 2.0 / (pixels * step)
    keep = np.nonzero(np.abs(frequencies) <= reach)[0]
    return (keep - pixels // 2) % pixels, frequencies[keep]


def _series(field: HeightField, parameters: BakeParameters) -> tuple[Series, np.ndarray, np.ndarray]:
    from scipy.fft import ifft2

    index_x, fx = _band(field.shape[1], field.dx)
    index_y, fy = _band(field.shape[0], field.dy)

    def transform(p: np.ndarray) -> np.ndarray:
        return ifft2(p, norm="forward")[np.ix_(index_y, index_x)]

    check_single_precision(parameters.series, 0.5 * KAPPA_MAX * float(np.ptp(field.heights)), parameters.tolerance)
    ones = np.ones((1, 1))
    return Series(field.heights, ones, KAPPA_MAX, parameters.series, parameters.tolerance, transform), fx, fy


def make_terms(field: HeightField, parameters: BakeParameters) -> Terms:
    """All terms of a prepared patch, in memory.

    Raises
    ------
    ParameterError
        If the series cannot reach the tolerance.
    """
    series, fx, fy = _series(field, parameters)
    images = np.stack([series.term(n).astype(np.complex64) for n in range(series.terms)])
    return Terms(images, fx, fy, series.method, series.kappa_max, series.half_range)


def save_terms(field: HeightField, parameters: BakeParameters, table_path: str | Path, key: str = "") -> Path:
    """Write the terms beside a table: ``<table>_terms/term_000_<hash>.exr`` ... (channels R, G = real, imaginary)
    and ``terms.json``, which names them.

    The hash is that of the patch and the series, so the images of two bakes have different names: until the
    JSON is replaced the old terms are whole, from then on the new ones, and the old images go last.

    Returns
    -------
    Path
        The folder.

    Raises
    ------
    OutputError
        If the folder cannot be written.
    """
    import OpenEXR

    series, fx, fy = _series(field, parameters)
    table_path = Path(table_path)
    folder = ensure_folder(table_path.with_name(f"{table_path.stem}_terms"))
    decides = repr((field.shape, field.dx, field.dy, parameters.series, parameters.tolerance)).encode()
    mark = hashlib.sha256(decides + np.ascontiguousarray(field.heights, "<f8").tobytes()).hexdigest()[:12]
    header = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}
    files = [f"term_{n:03d}_{mark}.exr" for n in range(series.terms)]
    for n, file in enumerate(files):
        image = series.term(n).astype(np.complex64)[::-1]
        channels = {"R": np.ascontiguousarray(image.real), "G": np.ascontiguousarray(image.imag)}
        with atomic_path(folder / file) as temporary:
            write_image(temporary, header, channels)
    description = {
        "format_version": TERMS_FORMAT_VERSION,
        "files": files,
        "key": key,
        "method": series.method,
        "terms": series.terms,
        "kappa_max": series.kappa_max,
        "half_range_m": series.half_range,
        "fx": [float(x) for x in fx],
        "fy": [float(y) for y in fy],
    }
    with atomic_path(folder / "terms.json") as temporary:
        Path(temporary).write_text(json.dumps(description, sort_keys=True) + "\n", encoding="utf-8")
    for old in set(folder.glob("term_*.exr")) - {folder / file for file in files}:
        old.unlink(missing_ok=True)
    return folder


def load_terms(folder: str | Path) -> Terms:
    """Read a folder written by :func:`save_terms`.

    Raises
    ------
    TableError
        If a file is missing, damaged or of another version.
    """
    folder = Path(folder)
    try:
        data = json.loads((folder / "terms.json").read_text(encoding="utf-8"))
        if data["format_version"] != TERMS_FORMAT_VERSION:
            raise TableError(f"The terms in {folder} are of another format version; bake the scan again.")
        images = np.stack([image[::-1] for image in _read_images(folder, data["files"])])
        fx, fy = np.array(data["fx"], float), np.array(data["fy"], float)
        if images.shape[1:] != (len(fy), len(fx)):
            raise ValueError("size")
        return Terms(
            images, fx, fy, data["method"], float(data["kappa_max"]), float(data["half_range_m"]), str(data["key"])
        )
    except TableError:
        raise
    except Exception as error:  # a missing file, broken JSON, or one of OpenEXR's bare exceptions
        raise TableError(f"The terms in {folder} cannot be read; bake the scan again.") from error


def _read_images(folder: Path, names: list[str]) -> Iterator[np.ndarray]:
    import OpenEXR

    for name in names:
        if Path(name).name != name:
            raise ValueError("outside the folder")
        with OpenEXR.File(os.fspath(folder / name), separate_channels=True) as file:
            channels = file.channels()
            yield channels["R"].pixels + 1j * channels["G"].pixels
