# SPDX-License-Identifier: GPL-3.0-or-later
"""What decides a bake: one frozen set of parameters for Python, operator and command line."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from .constants import TABLE_LIMIT_BYTES
from .errors import ParameterError
from .light.illuminant import ILLUMINANTS, Illuminant, illuminant_of, to_json

ENSEMBLES = ("average", "single", "periodic")
SERIES = ("nodes", "chebyshev", "taylor")
LEVELS = ("none", "plane", "poly2")
ROW_AXES = ("none", "x", "y")
TILINGS = ("none", "blend", "period")

__all__ = ["ENSEMBLES", "ILLUMINANTS", "LEVELS", "ROW_AXES", "SERIES", "TILINGS", "BakeParameters"]


@dataclass(frozen=True)
class BakeParameters:
    """Parameters of a bake in SI units.

    Parameters
    ----------
    sigma_s_m
        Standard deviation of the Gaussian coherence window in metres; None takes the
        default of the ensemble (``single``: 65 um / 4, ``average``: patch side / 10). ``periodic`` has no
        window and passes it over.
    ensemble
        ``average``: mean over all window positions; ``single``: one window in the middle; ``periodic``: the
        patch is one period, and all its copies are lit coherently.
    replicas
        Copies along x and y, for ``periodic``.
    series
        How p = exp(i kappa h) is transformed: ``nodes`` (one FFT at each Chebyshev node of
        kappa), ``chebyshev`` (Jacobi-Anger) or ``taylor`` (the thesis).
    tolerance
        Largest error of p that the series may leave, and of the interpolation in kappa.
    level
        ``none``, ``plane`` or ``poly2``.
    clip_percent
        Keeps the middle percent of heights (dust clip); None clips nothing.
    crop_m
        Rectangle that is kept: left, right, bottom and top in metres from the left and the bottom; None keeps all.
    align_rows
        Subtract each scan line's median along the fast axis ``x`` or ``y``; ``none`` by default, since it
        erases a structure that runs along the lines.
    smooth_m
        Standard deviation of a Gaussian over the heights in metres; 0 smooths nothing.
    tile
        Make opposite edges fit by ``blend`` or by a crop to whole periods (``period``).
    illuminant
        Spectral distribution of the light: a name of `ILLUMINANTS` or a `precompute.light.illuminant.Spectrum`, whose
        samples (not its name) then decide the table.
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
    replicas: tuple[int, int] = (8, 8)
    series: str = "nodes"
    tolerance: float = 1e-4
    level: str = "none"
    clip_percent: float | None = None
    crop_m: tuple[float, float, float, float] | None = None
    align_rows: str = "none"
    smooth_m: float = 0.0
    tile: str = "none"
    illuminant: Illuminant = "D65"
    detail: float = 1.0
    limit_bytes: int = TABLE_LIMIT_BYTES

    def __post_init__(self) -> None:
        if self.sigma_s_m is not None and not (math.isfinite(self.sigma_s_m) and self.sigma_s_m > 0):
            raise ParameterError(f"sigma_s is {self.sigma_s_m} m; it must be a positive length.")
        for name, value, choices in (
            ("ensemble", self.ensemble, ENSEMBLES),
            ("series", self.series, SERIES),
            ("level", self.level, LEVELS),
            ("axis of row alignment", self.align_rows, ROW_AXES),
            ("tiling", self.tile, TILINGS),
        ):
            if value not in choices:
                raise ParameterError(f"The {name} {value!r} is unknown; choose one of {', '.join(choices)}.")
        object.__setattr__(self, "illuminant", illuminant_of(self.illuminant))
        object.__setattr__(self, "replicas", tuple(int(n) for n in self.replicas))
        if len(self.replicas) != 2 or min(self.replicas) < 1:
            raise ParameterError(f"The copies {self.replicas} make no surface; give two whole numbers of at least 1.")
        if not (math.isfinite(self.tolerance) and 0.0 < self.tolerance < 1.0):
            raise ParameterError(f"The tolerance is {self.tolerance}; it must lie between 0 and 1.")
        if self.clip_percent is not None and not 0.0 < self.clip_percent <= 100.0:
            raise ParameterError(
                f"Clip keeps {self.clip_percent} percent of the heights; give more than 0, at most 100."
            )
        if self.crop_m is not None:
            object.__setattr__(self, "crop_m", tuple(float(x) for x in self.crop_m))
            left, right, bottom, top = self.crop_m if len(self.crop_m) == 4 else (0.0, 0.0, 0.0, 0.0)
            if not (0.0 <= left < right < math.inf and 0.0 <= bottom < top < math.inf):
                raise ParameterError(
                    f"The crop {self.crop_m} m makes no sense; give left < right and bottom < top in metres."
                )
        if not (math.isfinite(self.smooth_m) and self.smooth_m >= 0.0):
            raise ParameterError(f"Smoothing over {self.smooth_m} m makes no sense; give a length of 0 or more.")
        if not (math.isfinite(self.detail) and 0.1 <= self.detail <= 8.0):
            raise ParameterError(f"The detail is {self.detail}; it must lie between 0.1 and 8.")
        if self.limit_bytes <= 0:
            raise ParameterError("The size limit of a table must be positive.")

    def to_dict(self) -> dict[str, Any]:
        """What decides the table's content, for the sidecar (the limit does not)."""
        data = {each.name: getattr(self, each.name) for each in fields(self)}
        del data["limit_bytes"]
        data["illuminant"] = to_json(self.illuminant, name=False)
        if self.ensemble != "periodic":
            del data["replicas"]
        return data
