# SPDX-License-Identifier: GPL-3.0-or-later
"""What decides a bake: one frozen set of parameters for Python, operator and command line."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

from .constants import TABLE_LIMIT_BYTES
from .errors import ParameterError

ENSEMBLES = ("average", "single")
SERIES = ("nodes", "chebyshev", "taylor")
LEVELS = ("none", "plane", "poly2")
ILLUMINANTS = ("D65", "D50", "A", "E", "FL11")


@dataclass(frozen=True)
class BakeParameters:
    """Parameters of a bake in SI units.

    Parameters
    ----------
    sigma_s_m
        Standard deviation of the Gaussian coherence window in metres; None takes the
        default of the ensemble (``single``: 65 um / 4, ``average``: patch side / 10).
    ensemble
        ``average``: mean over all window positions; ``single``: one window in the middle.
    series
        How p = exp(i kappa h) is transformed: ``nodes`` (one FFT at each Chebyshev node of
        kappa), ``chebyshev`` (Jacobi-Anger) or ``taylor`` (the thesis).
    tolerance
        Largest error of p that the series may leave, and of the interpolation in kappa.
    level
        ``none``, ``plane`` or ``poly2``.
    clip_percent
        Keeps the middle percent of heights (dust clip); None clips nothing.
    illuminant
        Spectral distribution of the light, by name.
    detail
        Resolution of the table relative to the default 1.0; texels grow with its cube.
    limit_bytes
        Largest table that may be made, in bytes of texels as a renderer loads them.

    Raises
    ------
    ParameterError
        If a value is out of its range.
    """

    sigma_s_m: float | None = None
    ensemble: str = "average"
    series: str = "nodes"
    tolerance: float = 1e-4
    level: str = "none"
    clip_percent: float | None = None
    illuminant: str = "D65"
    detail: float = 1.0
    limit_bytes: int = TABLE_LIMIT_BYTES

    def __post_init__(self) -> None:
        if self.sigma_s_m is not None and not (math.isfinite(self.sigma_s_m) and self.sigma_s_m > 0):
            raise ParameterError(f"sigma_s is {self.sigma_s_m} m; it must be a positive length.")
        for name, value, choices in (
            ("ensemble", self.ensemble, ENSEMBLES),
            ("series", self.series, SERIES),
            ("level", self.level, LEVELS),
            ("illuminant", self.illuminant, ILLUMINANTS),
        ):
            if value not in choices:
                raise ParameterError(f"The {name} {value!r} is unknown; choose one of {', '.join(choices)}.")
        if not (math.isfinite(self.tolerance) and 0.0 < self.tolerance < 1.0):
            raise ParameterError(f"The tolerance is {self.tolerance}; it must lie between 0 and 1.")
        if self.clip_percent is not None and not 0.0 < self.clip_percent <= 100.0:
            raise ParameterError(
                f"Clip keeps {self.clip_percent} percent of the heights; give more than 0, at most 100."
            )
        if not (math.isfinite(self.detail) and 0.1 <= self.detail <= 8.0):
            raise ParameterError(f"The detail is {self.detail}; it must lie between 0.1 and 8.")
        if self.limit_bytes <= 0:
            raise ParameterError("The size limit of a table must be positive.")

    def to_dict(self) -> dict[str, Any]:
        """What decides the table's content, for the sidecar (the limit does not)."""
        data = asdict(self)
        del data["limit_bytes"]
        return data
