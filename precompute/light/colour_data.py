# SPDX-License-Identifier: GPL-3.0-or-later
"""What every bake needs of colour-science, kept beside this file: ``colour_data.json``.

Importing the library takes longer than baking; these few hundred numbers are copied from it by
``tools/build/colour_data.py``, and a test holds them equal to it.
"""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

PATH = Path(__file__).with_name("colour_data.json")


@lru_cache(maxsize=1)
def _data() -> dict[str, Any]:
    return json.loads(PATH.read_text(encoding="utf-8"))


def observer() -> tuple[np.ndarray, np.ndarray]:
    """``(n,)`` wavelengths in nm and ``(n, 3)`` colour matching functions of the CIE 1931 2 degree observer."""
    entry = _data()["observer"]
    return np.array(entry["wavelengths_nm"]), np.array(entry["xyz"])


def illuminant(name: str) -> tuple[np.ndarray, np.ndarray]:
    """``(n,)`` wavelengths in nm and ``(n,)`` relative power of an illuminant of the CIE."""
    entry = _data()["illuminants"][name]
    return np.array(entry["wavelengths_nm"]), np.array(entry["power"])


def bradford() -> np.ndarray:
    """``(3, 3)`` matrix from XYZ to the cone responses of Bradford's chromatic adaptation (Lam, 1985)."""
    return np.array(_data()["bradford"])


def space(name: str) -> tuple[np.ndarray, np.ndarray]:
    """``(3, 2)`` chromaticities xy of the primaries and ``(2,)`` of the white, by a space's name in colour-science."""
    entry = _data()["spaces"][name]
    return np.array(entry["primaries"]), np.array(entry["white"])
