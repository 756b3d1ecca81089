# SPDX-License-Identifier: GPL-3.0-or-later
"""One real quantity over the wavelength: a table of figures or a dispersion formula.

The formulas are those of the database refractiveindex.info, by its numbers, with the wavelength in micrometres:

1. Sellmeier, ``n^2 = 1 + c1 + sum c_2i L^2 / (L^2 - c_(2i+1)^2)``
2. Sellmeier with squares, ``n^2 = 1 + c1 + sum c_2i L^2 / (L^2 - c_(2i+1))``
3. polynomial, ``n^2 = c1 + sum c_2i L^c_(2i+1)``
4. ``n^2 = c1 + c2 L^c3 / (L^2 - c4^c5) + c6 L^c7 / (L^2 - c8^c9) + sum c_2i L^c_(2i+1)``
5. Cauchy, ``n = c1 + sum c_2i L^c_(2i+1)``
6. gases, ``n = 1 + c1 + sum c_2i / (c_(2i+1) - L^-2)``
7. Herzberger, ``n = c1 + c2 / (L^2 - 0.028) + c3 / (L^2 - 0.028)^2 + c4 L^2 + c5 L^4 + c6 L^6``
8. ``(n^2 - 1) / (n^2 + 2) = c1 + c2 L^2 / (L^2 - c3) + c4 L^2``
9. ``n^2 = c1 + c2 / (L^2 - c3) + c4 (L - c5) / ((L - c5)^2 + c6)``
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M
from ..errors import ParameterError

FORMULAS = tuple(range(1, 10))

_SLACK_M = 1e-12


@dataclass(frozen=True)
class Curve:
    """A quantity over the wavelength.

    Parameters
    ----------
    kind
        ``constant`` (one number), ``table`` (the values at ``wavelengths_m``, linear in between), ``exponential``
        (``a exp(-lambda / b)`` of a and b in metres) or ``formula``.
    numbers
        Values or coefficients.
    wavelengths_m
        Of a table, rising.
    formula
        Number of the formula.
    range_m
        Where it was measured; a formula is continued beyond it.

    Raises
    ------
    ParameterError
        For a table that does not rise or does not cover the visible range, for an unknown formula and for figures that
        are not finite.
    """

    kind: str
    numbers: tuple[float, ...]
    wavelengths_m: tuple[float, ...] = ()
    formula: int = 0
    range_m: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not self.numbers or not all(math.isfinite(x) for x in (*self.numbers, *self.wavelengths_m)):
            raise ParameterError("holds a figure that is no finite number")
        if self.kind == "table":
            lam = np.array(self.wavelengths_m)
            if len(lam) != len(self.numbers) or (np.diff(lam) <= 0).any():
                raise ParameterError("is a table whose wavelengths do not rise; sort its lines, each wavelength once")
            if lam[0] > WAVELENGTH_MIN_M + _SLACK_M or lam[-1] < WAVELENGTH_MAX_M - _SLACK_M:
                raise ParameterError(
                    f"covers {lam[0] * 1e9:.4g}-{lam[-1] * 1e9:.4g} nm; a table of figures must cover 380-780 nm"
                )
        elif self.kind == "formula" and self.formula not in FORMULAS:
            raise ParameterError(f"has dispersion formula {self.formula}; formulas 1 to 9 are known")
        elif self.kind not in ("formula", "constant", "exponential"):
            raise ParameterError(f"is of kind {self.kind!r}, which is not known")

    def __call__(self, wavelengths_m: np.ndarray) -> np.ndarray:
        """Values at wavelengths in metres."""
        lam = np.asarray(wavelengths_m, float)
        if self.kind == "constant":
            return np.full(lam.shape, self.numbers[0])
        if self.kind == "table":
            return np.interp(lam, self.wavelengths_m, self.numbers)
        if self.kind == "exponential":
            return self.numbers[0] * np.exp(-lam / self.numbers[1])
        with np.errstate(all="ignore"):
            value = _formula(self.formula, self.numbers, lam * 1e6)
        if not np.isfinite(value).all():
            raise ParameterError("has a dispersion formula that gives no real index between 380 and 780 nm")
        return value

    @property
    def continued(self) -> bool:
        """Whether the visible range reaches beyond what was measured."""
        if self.range_m is None:
            return False
        return self.range_m[0] > WAVELENGTH_MIN_M + _SLACK_M or self.range_m[1] < WAVELENGTH_MAX_M - _SLACK_M


def _formula(number: int, given: tuple[float, ...], x: np.ndarray) -> np.ndarray:
    """Refractive index at wavelengths ``x`` in micrometres."""
    least = {4: 9, 7: 6, 8: 4, 9: 6}.get(number, 1)
    c = (*given, *(0.0,) * (least - len(given)))
    x2 = x**2
    nothing = np.zeros_like(x)
    pairs = list(zip(c[1::2], c[2::2], strict=False))
    if number == 1:
        return np.sqrt(1.0 + c[0] + sum(a * x2 / (x2 - b**2) for a, b in pairs))
    if number == 2:
        return np.sqrt(1.0 + c[0] + sum(a * x2 / (x2 - b) for a, b in pairs))
    if number == 3:
        return np.sqrt(c[0] + sum(a * x**b for a, b in pairs))
    if number == 4:
        square = c[0] + sum(c[i] * x ** c[i + 1] / (x2 - c[i + 2] ** c[i + 3]) for i in (1, 5) if c[i])
        return np.sqrt(square + sum(a * x**b for a, b in zip(c[9::2], c[10::2], strict=False)))
    if number == 5:
        return c[0] + sum((a * x**b for a, b in pairs), nothing)
    if number == 6:
        return 1.0 + c[0] + sum((a / (b - x**-2) for a, b in pairs), nothing)
    if number == 7:
        pole = 1.0 / (x2 - 0.028)
        return c[0] + c[1] * pole + c[2] * pole**2 + c[3] * x2 + c[4] * x2**2 + c[5] * x2**3
    if number == 8:
        ratio = c[0] + c[1] * x2 / (x2 - c[2]) + c[3] * x2
        return np.sqrt((1.0 + 2.0 * ratio) / (1.0 - ratio))
    return np.sqrt(c[0] + c[1] / (x2 - c[2]) + c[3] * (x - c[4]) / ((x - c[4]) ** 2 + c[5]))
