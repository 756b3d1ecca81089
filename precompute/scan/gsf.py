# SPDX-License-Identifier: GPL-3.0-or-later
"""Writing heightfields as Gwyddion Simple Field: SI units, free keys, NaN for missing points."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np

from ..errors import OutputError
from ..files.atomic import atomic_path
from .heightfield import HeightField


def write_gsf(field: HeightField, path: str | os.PathLike[str]) -> Path:
    """Write a heightfield so that :func:`precompute.readers.read_scan` gives it back.

    Heights are rounded to float32 (a relative 6e-8), sizes keep all digits. Besides the keys of
    the format the header holds ``Processing`` (the processing list as JSON) and, where known,
    ``SourceName``, ``SourceFormat`` and ``SourceSha256``.

    Parameters
    ----------
    field
        The heightfield.
    path
        The file; replaced atomically.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    OutputError
        If the file cannot be written, or the heights do not fit in float32.
    """
    rows, cols = field.shape
    with np.errstate(over="ignore"):
        heights = np.where(field.missing, np.nan, field.heights).astype("<f4")
    if np.isinf(heights).any():
        raise OutputError(f"Cannot write '{path}': the heights are too large for the format.")
    header = {
        "XRes": cols,
        "YRes": rows,
        "XReal": repr(field.size_m[0]),
        "YReal": repr(field.size_m[1]),
        "XYUnits": "m",
        "ZUnits": "m",
        "Title": _one_line(field.metadata.get("channel") or "Height"),
        "Processing": json.dumps(list(field.processing), sort_keys=True, default=str),
    }
    for key, name in (("SourceName", "name"), ("SourceFormat", "format"), ("SourceSha256", "sha256")):
        value = field.metadata.get(key) or field.metadata.get(name)
        if value:
            header[key] = _one_line(value)
    text = "Gwyddion Simple Field 1.0\n" + "".join(f"{key} = {value}\n" for key, value in header.items())
    head = text.encode("utf-8")
    head += b"\0" * (4 - len(head) % 4)
    with atomic_path(path) as temporary, open(temporary, "wb") as file:
        file.write(head)
        file.write(np.ascontiguousarray(heights[::-1]).tobytes())
    return Path(path)


def _one_line(value: object) -> str:
    return " ".join(str(value).replace("\0", " ").split())
