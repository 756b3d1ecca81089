# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes that no microscope scans come from a unit that is not there: they are asked about, never taken."""

from __future__ import annotations

from ...errors import ScanError

#: Largest side and largest relief that are taken from a file without a question, metres.
LIMIT_SIDE_M, LIMIT_RELIEF_M = 10e-3, 1e-3


class ImplausibleReliefError(ScanError):
    """Heights that span more than any scan: another channel of the file may be the right one.

    Parameters
    ----------
    what
        The fact, a clause.
    advice
        What the user can do about it.
    """

    def __init__(self, what: str, advice: str) -> None:
        super().__init__(f"By the file {what}, {advice}.")
        self.what = what


def check_side(size_m: tuple[float, float]) -> None:
    """Refuse side lengths above a centimetre.

    Raises
    ------
    ScanError
        With the size and how to say that it is right, or another one.
    """
    if max(size_m) > LIMIT_SIDE_M:
        raise ScanError(
            f"By the file the scan is {named(size_m[0])} x {named(size_m[1])} large, so its unit of length is missing "
            "or wrong; give the size with --size-um X Y, or trust the file with --trust-units."
        )


def check_relief(relief_m: float) -> None:
    """Refuse heights that span more than a millimetre.

    Raises
    ------
    ScanError
        With the span and how to say that it is right, or another one.
    """
    if relief_m > LIMIT_RELIEF_M:
        raise ImplausibleReliefError(
            f"the heights span {named(relief_m)}",
            "so their unit is missing or wrong; give the height range with --height-nm H, or trust the file with "
            "--trust-units",
        )


def named(length_m: float) -> str:
    """A length with the prefix that suits it."""
    for factor, unit in ((1.0, "m"), (1e-3, "mm"), (1e-6, "um")):
        if length_m >= factor:
            return f"{length_m / factor:.4g} {unit}"
    return f"{length_m / 1e-9:.4g} nm"
