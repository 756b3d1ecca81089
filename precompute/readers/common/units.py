# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of length as instruments write them."""

from __future__ import annotations

#: Said where a file names no unit and its numbers suit metres.
ASSUMED_METRES = "the file names no unit of length for its sides, so metres were assumed"

_PREFIXES = {"": 1.0, "k": 1e3, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12, "f": 1e-15}
_NAMES = {
    "meter": 1.0,
    "metre": 1.0,
    "meters": 1.0,
    "metres": 1.0,
    "micron": 1e-6,
    "microns": 1e-6,
    "micrometer": 1e-6,
    "micrometre": 1e-6,
    "nanometer": 1e-9,
    "nanometre": 1e-9,
    "å": 1e-10,
    "ang": 1e-10,
    "angstrom": 1e-10,
    "ångström": 1e-10,
    "inch": 0.0254,
    "in": 0.0254,
}


def metres_per(unit: str | None) -> float | None:
    """Metres in one ``unit``, or None where it is not a length.

    Understands SI prefixes, the several letters that stand for micro, and Angstroem; a plain ``A``
    is the ampere of a current channel.
    """
    if unit is None:
        return None
    text = unit.strip().strip("[]()").replace("\N{GREEK SMALL LETTER MU}", "u").replace("\N{MICRO SIGN}", "u")
    text = text.replace("~", "u")  # Nanoscope and some exports write ~m for micrometres
    if text.endswith("m") and text[:-1] in _PREFIXES:
        return _PREFIXES[text[:-1]]
    return _NAMES.get(text.casefold())
