# SPDX-License-Identifier: GPL-3.0-or-later
"""What decides a bake: one frozen set of parameters for Python, operator and command line."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from .constants import FREQUENCY_MAX, PIXEL_MAX_M, REFINED_LIMIT_BYTES, TABLE_LIMIT_BYTES, W_MAX, WAVELENGTH_MIN_M
from .errors import ParameterError
from .light.illuminant import ILLUMINANTS, Illuminant, illuminant_of, to_json
from .stack import Material, Stack, material_of, stack_of
from .stack import to_json as stack_to_json

ENSEMBLES = ("average", "single", "periodic")
SERIES = ("nodes", "chebyshev", "taylor")
LEVELS = ("none", "plane", "poly2")
ROW_AXES = ("none", "x", "y")
TILINGS = ("none", "blend", "period")
ENERGY = ("raw", "capped")

#: Largest headroom.
HEADROOM_MOST = 8.0

#: Where the index of a lacquer is taken for directions: the sodium line (metres). And the indices that it may have.
LACQUER_WAVELENGTH_M = 589.3e-9
_LACQUER_LEAST, _LACQUER_MOST, _LACQUER_CLEAR = 1.0, 2.6, 0.01

__all__ = ["ENERGY", "ENSEMBLES", "ILLUMINANTS", "LEVELS", "ROW_AXES", "SERIES", "TILINGS", "BakeParameters"]


@dataclass(frozen=True)
class BakeParameters:
    """Parameters of a bake in SI units.

    Parameters
    ----------
    sigma_s_m
        Standard deviation of the Gaussian coherence window in metres; None takes the
        default of the ensemble (``single``: 65 um / 4, at most a quarter of the patch's shorter side; ``average``:
        a tenth of it). ``periodic`` has no
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
    error
        Largest error that linear lookups in the table may leave, a fraction, wherever a value is above 1e-3 of the
        largest in its plane of incidence: slices, radii and angles are chosen for it. A ``detail`` below 1 allows
        ``1 / detail^2`` times as much.
    stack
        The surface's stuff, a `precompute.stack.Stack` or what a sidecar holds of it: its reflectance goes into the
        table. None leaves it to the renderer.
    lacquer
        A clear layer over the relief, a `precompute.stack.Material` or what `material_of` takes; None is air.
    energy
        ``raw``: the table is the Kirchhoff integral, and renderers divide by albedos that hold at every wavelength;
        ``capped``: each wavelength is also cut by its own excess inside the table.
    scale_headroom, depth_headroom
        Largest Scale and Depth of a painted surface that the table is to hold for every direction; 1 is the surface as
        it is, more makes the table larger.
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
    error: float = 0.02
    stack: Stack | None = None
    lacquer: Material | None = None
    energy: str = "raw"
    scale_headroom: float = 1.0
    depth_headroom: float = 1.0
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
            ("energy model", self.energy, ENERGY),
        ):
            if value not in choices:
                raise ParameterError(f"The {name} {value!r} is unknown; choose one of {', '.join(choices)}.")
        object.__setattr__(self, "illuminant", illuminant_of(self.illuminant))
        object.__setattr__(self, "stack", stack_of(self.stack))
        if self.lacquer is not None:
            object.__setattr__(self, "lacquer", material_of(self.lacquer))
            index = self.lacquer.index(np.array([LACQUER_WAVELENGTH_M]))[0]
            if not (_LACQUER_LEAST <= index.real <= _LACQUER_MOST and index.imag <= _LACQUER_CLEAR):
                raise ParameterError(
                    f"The lacquer '{self.lacquer.name}' has the index {index.real:.4g} + {index.imag:.2g}i; a clear"
                    f" layer has n from {_LACQUER_LEAST:g} to {_LACQUER_MOST:g} and no k, for instance PMMA or 1.5."
                )
        if self.series != "nodes" and not (self.stack is None and self.lacquer is None):
            raise ParameterError(
                f"The series '{self.series}' is there for the thesis's own method, which knows neither films nor"
                " lacquer; choose the series 'nodes'."
            )
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
                x, y = (f"from {1e6 * low:.6g} to {1e6 * high:.6g} um" for low, high in ((left, right), (bottom, top)))
                raise ParameterError(f"A crop {x} in x and {y} in y makes no sense; give left < right, bottom < top.")
        if not (math.isfinite(self.smooth_m) and self.smooth_m >= 0.0):
            raise ParameterError(
                f"Smoothing over {1e9 * self.smooth_m:.6g} nm makes no sense; give a length of 0 or more."
            )
        if not (math.isfinite(self.detail) and 0.1 <= self.detail <= 8.0):
            raise ParameterError(f"The detail is {self.detail}; it must lie between 0.1 and 8.")
        if not (math.isfinite(self.error) and 0.001 <= self.error <= 1.0):
            raise ParameterError(f"The error is {100 * self.error:g} percent; it must lie between 0.1 and 100 percent.")
        for what, headroom in (("Scale", self.scale_headroom), ("Depth", self.depth_headroom)):
            if not (math.isfinite(headroom) and 1.0 <= headroom <= HEADROOM_MOST):
                raise ParameterError(
                    f"The headroom of {what} is {headroom:g}; it must lie between 1 and {HEADROOM_MOST:g}."
                )
        if self.series != "nodes" and (self.scale_headroom, self.depth_headroom) != (1.0, 1.0):
            raise ParameterError(f"The series '{self.series}' knows no headroom; choose the series 'nodes'.")
        if self.limit_bytes <= 0:
            raise ParameterError("The size limit of a table must be positive.")

    @property
    def index(self) -> float:
        """Refractive index of what lies over the relief, for directions: 1 for air."""
        return 1.0 if self.lacquer is None else float(self.lacquer.index(np.array([LACQUER_WAVELENGTH_M]))[0].real)

    @property
    def refined_bytes(self) -> int:
        """Most texels that a table may grow to for the sake of its error."""
        return min(self.limit_bytes, REFINED_LIMIT_BYTES)

    @property
    def error_goal(self) -> float:
        """The error that is asked for at this detail."""
        return self.error / min(self.detail, 1.0) ** 2

    @property
    def w_max(self) -> float:
        """Largest ``|w|``: 2, or 2 n under a lacquer, times the headroom of depth."""
        return W_MAX * self.index * self.depth_headroom

    @property
    def frequency_max(self) -> float:
        """Largest spatial frequency ``|(u, v)| / lambda`` that the table holds, 1/m."""
        return FREQUENCY_MAX * self.scale_headroom

    @property
    def pixel_max_m(self) -> float:
        """Pixels above this would put false orders into the table, metres."""
        return PIXEL_MAX_M / self.scale_headroom

    @property
    def kappa_max(self) -> float:
        """Largest kappa = k ``|w|`` that visible light reaches, 1/m."""
        return 2.0 * math.pi * self.w_max / WAVELENGTH_MIN_M

    def to_dict(self) -> dict[str, Any]:
        """What decides the table's content, for the sidecar (the limit does where it is a small one)."""
        data = {each.name: getattr(self, each.name) for each in fields(self)}
        if self.refined_bytes == REFINED_LIMIT_BYTES:
            del data["limit_bytes"]
        data["illuminant"] = to_json(self.illuminant, name=False)
        if self.ensemble != "periodic":
            del data["replicas"]
        # What is not there leaves no trace: such tables have the keys that they would have without the choice.
        data["stack"] = stack_to_json(self.stack)
        data["lacquer"] = None if self.lacquer is None else self.lacquer.to_json()
        for name in ("stack", "lacquer"):
            if data[name] is None:
                del data[name]
        for name in ("scale_headroom", "depth_headroom"):
            if data[name] == 1.0:
                del data[name]
        return data
