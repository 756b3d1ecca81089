# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials by name, by numbers and from files: complex refractive index n + ik over the wavelength, k >= 0.

Light is ``exp(i (k z - omega t))``, so that a positive k absorbs.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M
from ..errors import ParameterError
from .dispersion import Curve

_PATH = Path(__file__).with_name("materials.json")

#: Beyond these no solid or liquid lies in visible light; what does has another unit.
_LARGEST_N, _LARGEST_K = 20.0, 50.0


@dataclass(frozen=True)
class Material:
    """What light meets.

    Two materials are equal where their figures are; name and source do not count.

    Parameters
    ----------
    name
        Of the list, of the file, or the numbers themselves.
    n, k
        Refractive index and extinction; None is k = 0.
    source
        Paper or file.

    Raises
    ------
    ParameterError
        If an index is not positive, or k negative, anywhere in the visible range.
    """

    name: str = field(compare=False)
    n: Curve
    k: Curve | None = None
    source: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        lam = np.linspace(WAVELENGTH_MIN_M, WAVELENGTH_MAX_M, 81)
        try:
            n, k = self.n(lam), np.zeros(1) if self.k is None else self.k(lam)
        except ParameterError as error:
            raise ParameterError(f"The material '{self.name}' {error}.") from None
        if not (n.min() > 0.0 and n.max() <= _LARGEST_N):
            at = n.min() if n.min() <= 0.0 else n.max()
            raise ParameterError(
                f"The material '{self.name}' has a refractive index of {at:.4g}; it must lie above 0, at most"
                f" {_LARGEST_N:g}."
            )
        if not (k.min() >= 0.0 and k.max() <= _LARGEST_K):
            at = k.min() if k.min() < 0.0 else k.max()
            raise ParameterError(
                f"The material '{self.name}' has an extinction of k = {at:.4g}; it must lie from 0 to {_LARGEST_K:g}."
            )

    def index(self, wavelengths_m: np.ndarray) -> np.ndarray:
        """Complex index n + ik at wavelengths in metres; formulas are continued beyond their range."""
        lam = np.asarray(wavelengths_m, float)
        return self.n(lam) + 1j * (0.0 if self.k is None else self.k(lam))

    @property
    def note(self) -> str:
        """What is to be said of its range: empty, or that it is continued."""
        if not self.n.continued or self.n.range_m is None:
            return ""
        low, high = (1e9 * x for x in self.n.range_m)
        return f"{self.name} was measured at {low:.4g}-{high:.4g} nm; its formula is continued to 380-780 nm"

    def to_json(self) -> str | dict[str, Any]:
        """A name of the list, numbers as they are typed, or all figures; `material_of` reads it back."""
        if self.name in MATERIALS and MATERIALS[self.name] == self:
            return self.name
        if self.n.kind == "constant" and (self.k is None or self.k.kind == "constant"):
            return number_text(self.n.numbers[0], 0.0 if self.k is None else self.k.numbers[0])
        curves = {"n": _curve_json(self.n)}
        if self.k is not None:
            curves["k"] = _curve_json(self.k)
        return {"name": self.name, "source": self.source, **curves}


def number_text(n: float, k: float) -> str:
    """``n`` or ``n,k`` as a material is typed."""
    return f"{n!r},{k!r}" if k else repr(n)


def _curve_json(curve: Curve) -> dict[str, Any]:
    data: dict[str, Any] = {"kind": curve.kind, "numbers": list(curve.numbers)}
    if curve.kind == "table":
        data["wavelengths_m"] = list(curve.wavelengths_m)
    if curve.kind == "formula":
        data["formula"] = curve.formula
    if curve.range_m is not None:
        data["range_m"] = list(curve.range_m)
    return data


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
        found[entry["name"]] = Material(entry["name"], n, k, entry["source"])
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
        from .material_files import read_material

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
