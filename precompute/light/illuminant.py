# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of a bake: one of the CIE's by name, or a measured spectrum from a file of two columns."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..constants import WAVELENGTH_MAX_M, WAVELENGTH_MIN_M
from ..errors import ParameterError

#: Names that colour-science knows too.
ILLUMINANTS = ("D65", "D50", "A", "E", "FL11")

#: Fewest and most samples within the visible range, and the largest file that is read.
_FEWEST, _MOST, _LARGEST_BYTES = 5, 20000, 4 * 1024 * 1024

_SLACK_NM = 1e-6
_SEPARATORS = re.compile(r"[;\t ]+")
_DECIMAL_COMMA = re.compile(r"(?<=\d),(?=\d)")


@dataclass(frozen=True)
class Spectrum:
    """Relative spectral power of a light, linear between its samples.

    Two spectra are equal where their samples are; the name does not count.

    Parameters
    ----------
    wavelengths_m
        Rising, in metres, from 380 nm or below to 780 nm or above.
    power
        One value a wavelength, in any unit, none negative.
    name
        What to call it, e.g. its file's name.

    Raises
    ------
    ParameterError
        If it is no light: see the messages.
    """

    wavelengths_m: tuple[float, ...]
    power: tuple[float, ...]
    name: str = field(default="spectrum", compare=False)

    def __post_init__(self) -> None:
        lam, power = (np.array(x, float) for x in (self.wavelengths_m, self.power))
        what = f"The light '{self.name}'"
        if lam.shape != power.shape or lam.ndim != 1:
            raise ParameterError(f"{what} has {lam.size} wavelengths and {power.size} values; give one value each.")
        if not (np.isfinite(lam).all() and np.isfinite(power).all()):
            raise ParameterError(f"{what} holds a value that is no finite number; mend or leave out its line.")
        falls = np.flatnonzero(np.diff(lam) <= 0)
        if falls.size:
            raise ParameterError(
                f"{what} goes from {lam[falls[0]] * 1e9:g} to {lam[falls[0] + 1] * 1e9:g} nm; sort its lines by rising"
                " wavelength, each one once."
            )
        if (power < 0).any():
            at = lam[np.argmax(power < 0)] * 1e9
            raise ParameterError(f"{what} is negative at {at:g} nm; set values below the noise to 0.")
        low, high = WAVELENGTH_MIN_M * 1e9, WAVELENGTH_MAX_M * 1e9
        if not lam.size or lam[0] * 1e9 > low + _SLACK_NM or lam[-1] * 1e9 < high - _SLACK_NM:
            reach = f"covers {lam[0] * 1e9:g}-{lam[-1] * 1e9:g} nm" if lam.size else "is empty"
            raise ParameterError(f"{what} {reach}; it must cover {low:g}-{high:g} nm, with zeros where nothing shines.")
        inside = int(((lam >= WAVELENGTH_MIN_M - 1e-15) & (lam <= WAVELENGTH_MAX_M + 1e-15)).sum())
        if not _FEWEST <= inside <= _MOST:
            raise ParameterError(
                f"{what} has {inside} samples between {low:g} and {high:g} nm; give at least {_FEWEST} and at most"
                f" {_MOST}, for instance one each 5 nm."
            )
        if not power[(lam > WAVELENGTH_MIN_M) & (lam < WAVELENGTH_MAX_M)].any():
            raise ParameterError(f"{what} is dark between {low:g} and {high:g} nm; choose a light that can be seen.")
        object.__setattr__(self, "wavelengths_m", tuple(lam.tolist()))
        object.__setattr__(self, "power", tuple(power.tolist()))

    def __str__(self) -> str:
        return Path(self.name).stem

    def on(self, grid_m: np.ndarray) -> np.ndarray:
        """Power at the wavelengths of a quadrature.

        Where the grid is finer than the samples: linear between these, as CIE 15:2018, 4.2 has it for illuminants.
        Where the samples are finer: means over the hat functions of the grid, so that no narrow line falls
        between two of its wavelengths.

        Parameters
        ----------
        grid_m
            ``(L,)`` rising wavelengths in metres, within those of the light.

        Returns
        -------
        ndarray
            ``(L,)``.
        """
        lam, power = np.array(self.wavelengths_m), np.array(self.power)
        within = lam[(lam >= grid_m[0]) & (lam <= grid_m[-1])]
        if np.diff(within).min(initial=math.inf) >= np.diff(grid_m).min() * (1 - 1e-6):
            return np.interp(grid_m, lam, power)
        knots = np.union1d(grid_m, within)
        total = np.zeros_like(grid_m)
        left, right = knots[:-1], knots[1:]
        cell = np.clip(np.searchsorted(grid_m, 0.5 * (left + right)) - 1, 0, len(grid_m) - 2)
        start, width = grid_m[cell], np.diff(grid_m)[cell]
        # Power times hat is quadratic between knots: Simpson's rule is exact.
        for x, weight in ((left, 1.0), (0.5 * (left + right), 4.0), (right, 1.0)):
            share = (x - start) / width
            part = np.interp(x, lam, power) * (right - left) * (weight / 6.0)
            np.add.at(total, cell, part * (1.0 - share))
            np.add.at(total, cell + 1, part * share)
        step = np.diff(grid_m)
        hats = np.concatenate([step[:1], step[:-1] + step[1:], step[-1:]]) / 2.0
        return total / hats


#: A name of `ILLUMINANTS`, or a measured one.
Illuminant = str | Spectrum


def read_spectrum(path: str | Path) -> Spectrum:
    """A light from a text file: wavelength in nanometres and relative power, one pair a line.

    Columns are separated by commas, semicolons, tabs or blanks (with the last three a decimal comma is understood);
    lines before the first pair are a header, and so are empty lines and those that begin with ``#``.

    Raises
    ------
    ParameterError
        If the file cannot be read or is no light; the message says which line.
    """
    path = Path(path)
    what = f"The light's file '{path.name}'"
    try:
        if path.stat().st_size > _LARGEST_BYTES:
            raise ParameterError(f"{what} is larger than 4 MB; give two columns, wavelength in nm and power.")
        raw = path.read_bytes()
    except OSError as error:
        raise ParameterError(f"{what} cannot be read ({error.strerror or error}); choose another.") from error
    if b"\0" in raw:
        raise ParameterError(f"{what} is no text; give two columns, wavelength in nm and power.")
    pairs: list[tuple[float, float]] = []
    for number, line in enumerate(raw.decode("utf-8-sig", "replace").splitlines(), 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        values = _numbers(line)
        numbers = [value for value in values if value is not None]
        if len(values) == len(numbers) == 2:
            pairs.append((numbers[0] * 1e-9, numbers[1]))
        elif pairs or sum(value is not None for value in values) > 1:
            raise ParameterError(
                f"{what} has no pair of wavelength and power in line {number} ('{line.strip()[:40]}'); give two columns"
                " of numbers."
            )
    if not pairs:
        raise ParameterError(f"{what} holds no numbers; give two columns, wavelength in nm and power.")
    wavelengths, power = zip(*pairs, strict=True)
    return Spectrum(wavelengths, power, name=path.name)


def _numbers(line: str) -> list[float | None]:
    """The line's columns, None where one is no number."""
    line = line.strip()
    if _SEPARATORS.search(re.sub(r",\s+", ",", line)):
        columns = _SEPARATORS.split(_DECIMAL_COMMA.sub(".", line))
        columns = [column.strip(",") for column in columns]
    else:
        columns = line.split(",")
    found: list[float | None] = []
    for column in columns:
        try:
            found.append(float(column))
        except ValueError:
            found.append(None)
    return found[:-1] if len(found) == 3 and not columns[-1].strip() else found


def illuminant_of(value: Any) -> Illuminant:
    """The light that a name, a `Spectrum`, an entry of a sidecar or its JSON text means.

    Raises
    ------
    ParameterError
        If it is none.
    """
    if isinstance(value, Spectrum) or value in ILLUMINANTS:
        return value
    if isinstance(value, str) and value.startswith("{"):
        try:
            value = json.loads(value)
        except ValueError:
            value = None
    if isinstance(value, Mapping):
        try:
            wavelengths, power = (tuple(map(float, value[key])) for key in ("wavelengths_m", "power"))
            return Spectrum(wavelengths, power, _name_of(value))
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            raise ParameterError("The illuminant's spectrum is damaged; choose its file again.") from error
    raise ParameterError(
        f"The illuminant {str(value)[:60]!r} is unknown; choose one of {', '.join(ILLUMINANTS)}, or a file of two"
        " columns (wavelength in nm, power)."
    )


def _name_of(value: Mapping[str, Any]) -> str:
    return str(value.get("name", "spectrum"))


def to_json(illuminant: Illuminant, name: bool = True) -> str | dict[str, Any]:
    """What a sidecar holds of a light; `illuminant_of` reads it back, bit by bit.

    Parameters
    ----------
    illuminant
        Name or spectrum.
    name
        Whether a spectrum's name is kept; it decides nothing.
    """
    if isinstance(illuminant, str):
        return illuminant
    data: dict[str, Any] = {"wavelengths_m": list(illuminant.wavelengths_m), "power": list(illuminant.power)}
    return {**data, "name": illuminant.name} if name else data
