# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials by name, by numbers and from files."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..errors import ParameterError
from .dispersion import Curve
from .material import Material, number_text
from .material_files import read_material

_PATH = Path(__file__).with_name("materials.json")


def _curve_of(data: Mapping[str, Any]) -> Curve:
    span = data.get("range_m")
    return Curve(
        str(data["kind"]),
        tuple(float(x) for x in data["numbers"]),
        tuple(float(x) for x in data.get("wavelengths_m", ())),
        int(data.get("formula", 0)),
        None if span is None else (float(span[0]), float(span[1])),
    )


def _listed() -> dict[str, Material]:
    found: dict[str, Material] = {}
    for entry in _entries():
        k = None
        if "table_nm_n_k" in entry:
            nm, real, imaginary = (tuple(column) for column in zip(*entry["table_nm_n_k"], strict=True))
            lam = tuple(x * 1e-9 for x in nm)
            n, k = Curve("table", real, lam), Curve("table", imaginary, lam)
        else:
            low, high = (x * 1e-9 for x in entry["range_nm"])
            n = Curve("formula", tuple(entry["coefficients"]), (), entry["formula"], (low, high))
            if "k_exponential" in entry:
                height, decay_nm = entry["k_exponential"]
                k = Curve("exponential", (height, decay_nm * 1e-9))
        found[entry["name"]] = Material(entry["name"], n, k, entry["source"], listed=True)
    return found


@lru_cache(maxsize=1)
def _entries() -> list[dict[str, Any]]:
    return json.loads(_PATH.read_text(encoding="utf-8"))


#: By the name that is shown; `material_of` also knows them by other names and in any case.
MATERIALS: dict[str, Material] = _listed()

_NAMES = {
    name.casefold(): entry["name"] for entry in _entries() for name in (entry["name"], *entry["aliases"])
}  # fmt: skip


def material_of(value: Any) -> Material:
    """The material that a name, numbers, a file or an entry of a sidecar means.

    Parameters
    ----------
    value
        A `Material`; a name of the list in any case (``au``, ``Gold``); a number or ``n,k``; the path of a CSV file or
        of a refractiveindex.info .yml; or what `Material.to_json` made.

    Raises
    ------
    ParameterError
        If it is none.
    """
    if isinstance(value, Material):
        return value
    if isinstance(value, int | float) and not isinstance(value, bool):
        return _of_numbers((float(value),), str(value))
    if isinstance(value, complex):
        return _of_numbers((value.real, value.imag), str(value))
    if isinstance(value, Mapping):
        try:
            k = None if value.get("k") is None else _curve_of(value["k"])
            return Material(str(value["name"]), _curve_of(value["n"]), k, str(value.get("source", "")))
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ParameterError("A material of the stack is damaged; choose it again.") from error
    text = str(value).strip()
    name = _NAMES.get(text.casefold())
    if name is not None:
        return MATERIALS[name]
    numbers = _numbers(text)
    if numbers is not None:
        return _of_numbers(numbers, text)
    if text and os.path.isfile(text):
        return read_material(text)
    raise ParameterError(
        f"There is no material '{text[:60]}'; choose one of {', '.join(MATERIALS)}, a number, n,k or a file (.csv,"
        " .yml)."
    )


def _numbers(text: str) -> tuple[float, ...] | None:
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        return None
    return numbers if len(numbers) <= 2 else None


def _of_numbers(numbers: tuple[float, ...], text: str) -> Material:
    if not all(math.isfinite(x) for x in numbers):
        raise ParameterError(f"The material '{text}' is no finite number; give an index such as 1.46, or n,k.")
    n, k = (*numbers, 0.0)[:2]
    return Material(number_text(n, k), Curve("constant", (n,)), Curve("constant", (k,)) if k else None)
