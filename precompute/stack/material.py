# SPDX-License-Identifier: GPL-3.0-or-later
"""What light meets: a complex refractive index n + ik over the wavelength, k >= 0.

Light is ``exp(i (k z - omega t))``, so that a positive k absorbs.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M
from ..errors import ParameterError
from .dispersion import Curve

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
    listed
        Whether the name is enough to find it again.

    Raises
    ------
    ParameterError
        If an index is not positive, or k negative, anywhere in the visible range.
    """

    name: str = field(compare=False)
    n: Curve
    k: Curve | None = None
    source: str = field(default="", compare=False)
    listed: bool = field(default=False, compare=False, repr=False)

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
        """A name of the list, numbers as they are typed, or all figures; `materials.material_of` reads it back."""
        if self.listed:
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
