# SPDX-License-Identifier: GPL-3.0-or-later
"""Coherence windows: the Gaussian in the middle of a patch, the taper of its rim, their default widths."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from ..constants import COHERENCE_LENGTH_SUN_M, TAPER_FRACTION
from ..errors import ParameterError
from ..parameters import ENSEMBLES
from ..scan.heightfield import HeightField

#: Largest window of its side that a patch does not cut off: side lobes of 6e-4.
SHARE_OF_SIDE = 0.25


def check_ensemble(ensemble: str) -> str:
    """The name of an ensemble, or ParameterError."""
    if ensemble not in ENSEMBLES:
        raise ParameterError(f"Unknown ensemble '{ensemble}'; choose one of {', '.join(ENSEMBLES)}.")
    return ensemble


def check_sigma_s(sigma_s_m: float) -> float:
    """A usable coherence width in metres, or ParameterError."""
    if not (np.isfinite(sigma_s_m) and sigma_s_m > 0):
        raise ParameterError(f"The coherence width sigma_s is {sigma_s_m * 1e6:g} um; give a positive number.")
    return float(sigma_s_m)


@dataclass(frozen=True)
class Coherence:
    """The coherence window in force, and what limits it.

    Parameters
    ----------
    sigma_s_m
        Standard deviation, metres; for ``periodic`` a width that is as fine as the lit surface.
    limit
        ``typed``, ``sunlight``, ``quarter of the side``, ``tenth of the side`` or ``copies``.
    side_lobes
        Height of the side lobes of a ``single`` window that the patch cuts off, over the peak; 0 for the others.
    """

    sigma_s_m: float
    limit: str
    side_lobes: float = 0.0

    def to_json(self) -> dict[str, float | str]:
        """For the sidecar."""
        return asdict(self)

    @property
    def warning(self) -> str:
        """One sentence where the patch cuts the window off; empty otherwise."""
        if self.limit != "typed" or self.side_lobes <= 1.5 * side_lobes(1.0, SHARE_OF_SIDE):
            return ""
        return (
            f"The coherence window of {self.sigma_s_m * 1e6:.4g} um is wider than a quarter of the patch, which cuts it"
            f" off: side lobes of {self.side_lobes:.1e} of the peak stand beside it"
        )


def side_lobes(side_m: float, sigma_s_m: float) -> float:
    """Height over the peak of the highest side lobe of ``|F{g}|^2``, g a Gaussian that ends at half of ``side_m``."""
    edge = 0.5 * side_m / sigma_s_m
    x = (np.arange(4096) + 0.5) / 2048.0 - 1.0
    power = np.abs(np.fft.rfft(np.exp(-0.5 * (x * edge) ** 2), 2**16)[: 2**12]) ** 2
    rising = np.flatnonzero(np.diff(power) > 0.0)
    return float(power[rising[0] :].max() / power[0]) if len(rising) else 0.0


def coherence(field: HeightField, ensemble: str, sigma_s_m: float | None) -> Coherence:
    """The coherence window that a patch, an ensemble and what was typed come to."""
    side = min(field.size_m)
    if check_ensemble(ensemble) == "periodic":
        return Coherence(default_sigma_s(field, ensemble), "copies")
    sigma_s = default_sigma_s(field, ensemble) if sigma_s_m is None else sigma_s_m
    if sigma_s_m is not None:
        limit = "typed"
    elif ensemble == "average":
        limit = "tenth of the side"
    else:
        limit = "quarter of the side" if sigma_s < COHERENCE_LENGTH_SUN_M / 4.0 else "sunlight"
    return Coherence(sigma_s, limit, side_lobes(side, sigma_s) if ensemble == "single" else 0.0)


def sunlight_sigma_s(field: HeightField) -> float:
    """Window of sunlight, a quarter of its coherence length, or what of it the patch allows: a quarter of its side."""
    return min(COHERENCE_LENGTH_SUN_M / 4.0, SHARE_OF_SIDE * min(field.size_m))


def default_sigma_s(field: HeightField, ensemble: str) -> float:
    """Standard deviation of the coherence window when none is given, in metres.

    ``single``: that of sunlight, at most a quarter of the patch's shorter side. ``average``: a tenth of the side.
    ``periodic`` has no window; the value is the width whose lobe is as wide as that of the lit surface,
    sinc^2 with half a maximum at 0.443 / side, and says how fine a table must be.
    """
    if check_ensemble(ensemble) == "periodic":
        return 0.3 * max(field.size_m)
    return sunlight_sigma_s(field) if ensemble == "single" else min(field.size_m) / 10.0


def gaussian_axis(count: int, step_m: float, sigma_s_m: float) -> np.ndarray:
    """``(count,)`` samples of exp(-x^2 / (2 sigma_s^2)), x measured from the middle of the axis.

    For an even count the middle lies between the two central samples.
    """
    x = (np.arange(count) - (count - 1) / 2.0) * step_m
    return np.exp(-0.5 * (x / sigma_s_m) ** 2)


def gaussian_window(field: HeightField, sigma_s_m: float) -> np.ndarray:
    """``(rows, cols)`` Gaussian coherence window in the middle of the patch, 1 at its centre."""
    rows, cols = field.shape
    return np.outer(gaussian_axis(rows, field.dy, sigma_s_m), gaussian_axis(cols, field.dx, sigma_s_m))


def window_axis(count: int, step_m: float, sigma_s_m: float, ensemble: str) -> np.ndarray:
    """``(count,)`` what the patch is multiplied by along one axis: Gaussian, taper, or 1 for ``periodic``."""
    if check_ensemble(ensemble) == "single":
        return gaussian_axis(count, step_m, sigma_s_m)
    return taper_axis(count) if ensemble == "average" else np.ones(count)


def taper_axis(count: int) -> np.ndarray:
    """``(count,)`` symmetric Tukey window, its end samples zero (Harris, 1978): the rim of the ensemble average.

    A cosine rolls off `TAPER_FRACTION` of the samples, half of them at either end.
    """
    place = np.arange(count) / max(count - 1, 1)
    rim = np.minimum(place, 1.0 - place) * (2.0 / TAPER_FRACTION)
    return np.where(rim < 1.0, 0.5 * (1.0 - np.cos(np.pi * np.minimum(rim, 1.0))), 1.0)


def taper(field: HeightField) -> np.ndarray:
    """``(rows, cols)`` separable Tukey taper t of the patch."""
    rows, cols = field.shape
    return np.outer(taper_axis(rows), taper_axis(cols))
